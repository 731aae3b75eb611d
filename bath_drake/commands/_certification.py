"""What `bath-drake certify` finds of a file: chains and their certificates."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from bath_drake.certificate_file import (
    certificate_to_mapping,
    chain_certificates_to_mapping,
)
from bath_drake.composition.certify import certify_chain
from bath_drake.composition.chain import Chain
from bath_drake.composition.result import ChainCertificate, whole_verdict
from bath_drake.errors import SkillFileError
from bath_drake.field_file import chains_to_mapping, field_to_mapping
from bath_drake.learning.skill import Skill
from bath_drake.notation import FloatArray
from bath_drake.skill_file import is_skill_file, load_chains, load_skill


@dataclass(frozen=True, eq=False)
class Certification:
    """A file's chains, one a branch, and what was proved of each.

    Attributes:
        skill: The file's, if it is a skill.
        chains: What was certified.
        certificates: Of each chain as a whole, from all its first field's free space.
        from_starts: Of each chain from its branch's start, where only that gives a
            proof of a region; else the same as above.
        moved: Of conditioned branches the chains for their demonstrations' own starts:
            branch, start (2,) in N, and the chain's certificate from there.
    """

    skill: Skill | None
    chains: tuple[Chain, ...]
    certificates: tuple[ChainCertificate, ...]
    from_starts: tuple[ChainCertificate, ...]
    moved: tuple[tuple[int, FloatArray, ChainCertificate], ...] = ()

    @property
    def starts(self) -> tuple[FloatArray, ...]:
        """Each branch's start, shape (2,); none if the file is no skill."""
        return () if self.skill is None else tuple(b.start for b in self.skill.branches)

    @property
    def is_single(self) -> bool:
        """Whether one field is all there is."""
        return len(self.chains) == 1 and len(self.chains[0]) == 1

    @property
    def passed(self) -> bool:
        """Whether every chain is proved as a whole."""
        return all(certificate.passed for certificate in self.certificates)

    @property
    def summary(self) -> str:
        """Verdict and reason in a line."""
        verdict, reason = whole_verdict(self.certificates)
        return f"{verdict}: {reason}"

    def to_mapping(self) -> dict[str, Any]:
        """As plain values: the block of a skill file, and what else is printed."""
        data = self._block(self.certificates)
        if not self.is_single:
            data["critical_points"] = [
                {"branch": stage["branch"], "stage": stage["stage"]} | point
                for stage in data["stages"]
                for point in stage["critical_points"]
            ]
            shown = (c.witness for c in self.certificates if c.witness is not None)
            witness = next(shown, None)
            data["witness"] = (
                None if witness is None else dict(zip("xy", witness, strict=True))
            )
        if self.from_starts != self.certificates:
            data["from_start"] = self._block(self.from_starts)
        if self.moved:
            data["demonstrated_starts"] = [
                {
                    "branch": b,
                    "x": float(start[0]),
                    "y": float(start[1]),
                    "verdict": certificate.verdict,
                    "reason": certificate.reason,
                }
                for b, start, certificate in self.moved
            ]
        data["seconds"] = sum(certificate.seconds for certificate in self.certificates)
        return data

    def _block(self, certificates: Sequence[ChainCertificate]) -> dict[str, Any]:
        if self.is_single:
            field = self.chains[0].fields[0]
            stage = certificates[0].stages[0]
            return certificate_to_mapping(stage, field_to_mapping(field))
        return chain_certificates_to_mapping(
            certificates, chains_to_mapping(self.chains)
        )


def certify_file(path: str, renew: bool) -> Certification:
    """Reads and certifies a file's fields; a skill's starts must be free too.

    A conditioned branch is another chain for every start: the verdict is that of its
    mean start's, and the demonstrations' own are certified besides.

    Raises:
        SkillFileError: Naming file and key; also to renew what is no skill.
    """
    if is_skill_file(path):
        skill = load_skill(path, renew=renew)
        pairs = [_certify_branch(b.chain, b.start) for b in skill.branches]
        certificates, from_starts = zip(*pairs, strict=True)
        moved = tuple(
            (b, start, certify_chain(branch.chain_for(start), start=start))
            for b, branch in enumerate(skill.branches)
            if branch.conditioning is not None
            for start in branch.starts
        )
        return Certification(skill, skill.chains, certificates, from_starts, moved)
    if renew:
        raise SkillFileError(f"{path}: --renew is for skills, this is none")
    chains = load_chains(path)
    found = tuple(certify_chain(chain) for chain in chains)
    return Certification(None, chains, found, found)


def _certify_branch(
    chain: Chain, start: FloatArray
) -> tuple[ChainCertificate, ChainCertificate]:
    """The chain's certificate as a whole, and the one from its start."""
    own = certify_chain(chain, start=start)
    if all(stage.region is None for stage in own.stages):
        # It is of the whole fields, or says that the start is not free.
        return own, own
    return certify_chain(chain), own
