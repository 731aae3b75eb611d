"""Skills as YAML files: strict to read, whole when written.

A skill file has the keys schema_version, finished, field, start, branches, seed,
config, demonstration_hashes, canonical, scale, frechet, certificate and checksum.
`field` is a mapping where one field is all there is, else a list of them (see
`bath_drake.field_file`). `start` is that of the first of `branches` (see
`bath_drake.branch_file`). With a periodic motion there is the key periodic too (see
`bath_drake.rhythm_file`). Floats come back to the last bit. The certificate names what
it is about by a checksum of the `field` block: one of another field is refused.

Files of version 2 are of a single field, have its mean demonstration beside `start`
and neither branches nor finished; those of version 1 held no checksum of the field.
"""

from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, get_args

import numpy as np

from bath_drake.branch_file import branch_to_mapping, take_branch
from bath_drake.certificate.result import Certificate
from bath_drake.certificate_file import (
    certificate_to_mapping,
    chain_certificates_to_mapping,
    content_checksum,
    take_certificate,
    take_chain_certificates,
)
from bath_drake.composition.branch import Branch
from bath_drake.composition.chain import Chain
from bath_drake.composition.result import ChainCertificate
from bath_drake.demonstrations.canonical import (
    CanonicalDemonstration,
    CanonicalFrame,
    FrameKind,
)
from bath_drake.errors import SkillFileError
from bath_drake.field.navigation import NavigationField
from bath_drake.field_file import chains_to_mapping, field_to_mapping, take_chains
from bath_drake.files import write_atomically
from bath_drake.learning.learner import LearningResult
from bath_drake.learning.skill import Skill
from bath_drake.rhythm.limit_cycle import LimitCycle
from bath_drake.rhythm_file import PERIODIC, cycle_to_mapping, take_cycle
from bath_drake.yaml_block import Block
from bath_drake.yaml_io import dump_yaml, read_yaml

SCHEMA_VERSION = 3
_OLDER = 2
FIELD, CERTIFICATE, CHECKSUM = "field", "certificate", "checksum"


def save_skill(path: str | Path, skill: Skill) -> None:
    """Writes a skill file whole, or leaves what was there.

    Raises:
        SkillFileError: When the file cannot be written, or the skill's certificate is
            not about its fields.
        ValueError: When `config` holds what YAML cannot.
    """
    data = skill_to_mapping(skill)
    block = Block(data, str(path), error=SkillFileError)
    _check_certificate(block, data)
    text = f"{dump_yaml(data)}{CHECKSUM}: {content_checksum(data)}\n"
    write_atomically(path, text, error=SkillFileError)


def load_skill(path: str | Path, *, renew: bool = False) -> Skill:
    """Reads a skill file.

    Args:
        path: The file.
        renew: Do not look at the certificate, and take files of version 1 too: the
            skill comes with none and can be given one (`certified`).

    Raises:
        SkillFileError: Naming file and key; also where the certificate in the file is
            about another field than the file's.
    """
    data = read_yaml(path, error=SkillFileError)
    block = Block(data, str(path), error=SkillFileError)
    version = _take_version(block, renew)
    _check_checksum(block, data)
    start = block.take_list("start", float, 2)
    seed = block.take("seed", int)
    config = block.take("config", dict)
    hashes = tuple(block.take_list("demonstration_hashes", str))
    canonical = _take_canonical(block.take_block("canonical"))
    scale = block.take("scale", float)
    figures = block.take_block("frechet")
    frechet = {key: figures.take(key, float) for key in data["frechet"]}
    chains = take_chains(block)
    if version < SCHEMA_VERSION:
        finished, branches = True, _take_old_branch(block, chains, start)
    else:
        finished = block.take("finished", bool)
        branches = _take_branches(block, chains, start)
    periodic = take_cycle(block.take_block(PERIODIC)) if block.has(PERIODIC) else None
    if renew:
        block.take(CERTIFICATE, dict)
    else:
        _check_certificate(block, data)
    block.finish()
    try:
        return Skill(
            branches=branches,
            seed=seed,
            config=config,
            demonstration_hashes=hashes,
            canonical=canonical,
            scale=scale,
            frechet=frechet,
            certificate={} if renew else data[CERTIFICATE],
            finished=finished,
            periodic=periodic,
        )
    except ValueError as problem:
        block.fail("", str(problem))


def load_chains(path: str | Path) -> tuple[Chain, ...]:
    """Reads the `field` block of a skill file or of any other YAML file.

    Other keys are not looked at, except that a skill's checksum must be right.

    Returns:
        A chain for each branch: one of one field where the block is a mapping.

    Raises:
        SkillFileError: Naming file and key.
    """
    data = read_yaml(path, error=SkillFileError)
    block = Block(data, str(path), error=SkillFileError)
    if CHECKSUM in data:
        _check_checksum(block, data)
    return take_chains(block)


def load_field(path: str | Path) -> NavigationField:
    """Reads a single field as `load_chains` does.

    Raises:
        SkillFileError: Naming file and key; also where there are several fields.
    """
    chains = load_chains(path)
    if len(chains) > 1 or len(chains[0]) > 1:
        count = sum(len(chain) for chain in chains)
        raise SkillFileError(f"{path}: {FIELD}: found {count} fields, expected one")
    return chains[0].fields[0]


def is_skill_file(path: str | Path) -> bool:
    """Whether a YAML file says that it is a skill; raises SkillFileError if unread."""
    return "schema_version" in read_yaml(path, error=SkillFileError)


def certified(skill: Skill, *certificates: Certificate | ChainCertificate) -> Skill:
    """Returns the skill with certificates that were made of its branches' chains.

    Args:
        skill: What they are about.
        certificates: One a branch; of a single skill that of the field will do.

    Raises:
        ValueError: There is not one for each branch.
    """
    chains = [
        ChainCertificate((c,)) if isinstance(c, Certificate) else c
        for c in certificates
    ]
    if [len(c.stages) for c in chains] != [len(c) for c in skill.chains]:
        raise ValueError("the certificates are not of the skill's branches")
    block = _field_block(skill.chains)
    if isinstance(block, list):
        return replace(skill, certificate=chain_certificates_to_mapping(chains, block))
    of_field = certificate_to_mapping(chains[0].stages[0], block)
    return replace(skill, certificate=of_field)


def skill_from_result(
    result: LearningResult,
    demonstrations: Sequence[CanonicalDemonstration],
    frame: CanonicalFrame,
    periodic: LimitCycle | None = None,
) -> Skill:
    """What is kept of learning: the same result gives the same skill, bit by bit."""
    skill = Skill(
        branches=result.branches,
        seed=result.config.seed,
        config=_plain(asdict(result.config)),
        demonstration_hashes=tuple(d.sha256 for d in demonstrations),
        canonical=frame,
        scale=result.scale,
        frechet=dict(result.frechet),
        finished=result.finished,
        periodic=periodic,
    )
    return certified(skill, *result.certificates)


def skill_to_mapping(skill: Skill) -> dict[str, Any]:
    """A skill as the tree of plain values its file holds, without the checksum."""
    frame = skill.canonical
    mapping = {
        "schema_version": SCHEMA_VERSION,
        "finished": bool(skill.finished),
        FIELD: _field_block(skill.chains),
        "start": skill.start.tolist(),
        "branches": [branch_to_mapping(branch) for branch in skill.branches],
        "seed": int(skill.seed),
        "config": _plain(skill.config),
        "demonstration_hashes": list(skill.demonstration_hashes),
        "canonical": {
            "kind": frame.kind,
            "origin": frame.origin.tolist(),
            "axes": frame.axes.tolist(),
            "scales": frame.scales.tolist(),
        },
        "scale": float(skill.scale),
        "frechet": _plain(skill.frechet),
        CERTIFICATE: _plain(skill.certificate),
    }
    if skill.periodic is not None:
        mapping[PERIODIC] = cycle_to_mapping(skill.periodic)
    return mapping


def _take_old_branch(
    block: Block, chains: tuple[Chain, ...], start: list[float]
) -> tuple[Branch, ...]:
    """The one branch of a file of version 1 or 2."""
    if len(chains) > 1 or len(chains[0]) > 1:
        block.fail(FIELD, f"found a list, version {_OLDER} holds a single field")
    mean = block.take_rows("mean_demonstration", None, 2)
    try:
        branch = Branch(
            chain=chains[0],
            start=np.array(start),
            starts=np.array([start]),
            mean=np.array(mean).reshape(-1, 2),
        )
    except ValueError as problem:
        block.fail("", str(problem))
    return (branch,)


def _take_branches(
    block: Block, chains: tuple[Chain, ...], start: list[float]
) -> tuple[Branch, ...]:
    blocks = block.take_blocks("branches")
    if len(blocks) != len(chains):
        block.fail(
            "branches",
            f"found {len(blocks)}, the fields make up {len(chains)}",
        )
    branches = tuple(take_branch(b, c) for b, c in zip(blocks, chains, strict=True))
    first = branches[0].start.tolist()
    if start != first:
        block.fail("start", f"found {start}, the first branch has {first}")
    return branches


def _check_certificate(file: Block, data: dict[str, Any]) -> None:
    """Takes the certificate, which must be about the fields beside it."""
    block = file.take_block(CERTIFICATE)
    if isinstance(data[FIELD], list):
        take_chain_certificates(block, data[FIELD])
    else:
        take_certificate(block, data[FIELD])


def _take_canonical(block: Block) -> CanonicalFrame:
    kind = block.take("kind", str)
    kinds = {name: name for name in get_args(FrameKind)}
    if kind not in kinds:
        block.fail("kind", f"found {kind!r}, expected one of {', '.join(kinds)}")
    dimension = 2 if kind == "planar" else 3
    origin = block.take_list("origin", float, dimension)
    axes = block.take_rows("axes", 2, dimension)
    scales = block.take_list("scales", float, 2)
    block.finish()
    try:
        return CanonicalFrame(
            kinds[kind], np.array(origin), np.array(axes), np.array(scales)
        )
    except ValueError as problem:
        block.fail("", str(problem))


def _field_block(chains: Sequence[Chain]) -> Any:
    """A mapping where one field is all there is, else a list."""
    if len(chains) == 1 and len(chains[0]) == 1:
        return field_to_mapping(chains[0].fields[0])
    return chains_to_mapping(chains)


def _take_version(block: Block, renew: bool) -> int:
    version = block.take("schema_version", int)
    if version in (SCHEMA_VERSION, _OLDER) or (renew and version == 1):
        return version
    message = f"found {version}, this version reads {_OLDER} and {SCHEMA_VERSION}"
    if version == 1:
        message += (
            "; a version 1 certificate is no proof and names no field: "
            "`bath-drake certify --renew` makes it anew"
        )
    block.fail("schema_version", message)


def _check_checksum(block: Block, data: dict[str, Any]) -> None:
    found = block.take(CHECKSUM, str)
    expected = content_checksum({key: data[key] for key in data if key != CHECKSUM})
    if found != expected:
        block.fail(
            CHECKSUM,
            f"found {found[:24]!r}, but the content gives {expected[:24]!r}: the file "
            "was changed or damaged after it was written",
        )


def _plain(value: Any) -> Any:
    """Tuples and numpy values as lists and Python numbers."""
    if isinstance(value, dict):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return _plain(value.tolist())
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value
