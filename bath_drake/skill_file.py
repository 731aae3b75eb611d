"""Skills and fields as YAML files: strict to read, whole when written.

A skill file has the keys schema_version, field, start, seed, config,
demonstration_hashes, canonical, mean_demonstration, scale, frechet, certificate
and checksum. Floats come back to the last bit. The certificate names the field it
is about by a checksum of the `field` block: one of another field is refused. Files
of version 1 held no such checksum. For the `field` block see `bath_drake.field_file`.
"""

from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, get_args

import numpy as np

from bath_drake.certificate.result import Certificate
from bath_drake.certificate_file import (
    certificate_to_mapping,
    content_checksum,
    take_certificate,
)
from bath_drake.composition.chain import Chain
from bath_drake.demonstrations.canonical import (
    CanonicalDemonstration,
    CanonicalFrame,
    FrameKind,
)
from bath_drake.errors import SkillFileError
from bath_drake.field.navigation import NavigationField
from bath_drake.field_file import field_from_mapping as field_from_mapping
from bath_drake.field_file import field_to_mapping as field_to_mapping
from bath_drake.field_file import take_chains
from bath_drake.learning.learner import LearningResult
from bath_drake.learning.skill import Skill
from bath_drake.yaml_io import Block, dump_yaml, read_yaml, write_atomically

SCHEMA_VERSION = 2
CHECKSUM = "checksum"


def save_skill(path: str | Path, skill: Skill) -> None:
    """Writes a skill file whole, or leaves what was there.

    Raises:
        SkillFileError: When the file cannot be written, or the skill's certificate is
            not about its field.
        ValueError: When `config` holds what YAML cannot.
    """
    data = skill_to_mapping(skill)
    certificate = data["certificate"]
    inner = Block(certificate, str(path), "certificate", SkillFileError)
    take_certificate(inner, data["field"])
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
    _check_version(block, renew)
    _check_checksum(block, data)
    start = block.take_list("start", float, 2)
    seed = block.take("seed", int)
    config = block.take("config", dict)
    hashes = tuple(block.take_list("demonstration_hashes", str))
    canonical = _take_canonical(block.take_block("canonical"))
    mean = block.take_rows("mean_demonstration", None, 2)
    scale = block.take("scale", float)
    figures = block.take_block("frechet")
    frechet = {key: figures.take(key, float) for key in data["frechet"]}
    field = _take_field(block)
    certificate = block.take("certificate", dict)
    if renew:
        certificate = {}
    else:
        inner = Block(certificate, str(path), "certificate", SkillFileError)
        take_certificate(inner, field_to_mapping(field))
    block.finish()
    try:
        return Skill(
            field=field,
            start=np.array(start),
            seed=seed,
            config=config,
            demonstration_hashes=hashes,
            canonical=canonical,
            mean_demonstration=np.array(mean),
            scale=scale,
            frechet=frechet,
            certificate=certificate,
        )
    except ValueError as problem:
        block.fail("", str(problem))


def load_field(path: str | Path) -> NavigationField:
    """Reads the `field` block of a skill file or of any other YAML file.

    Other keys are not looked at, except that a skill's checksum must be right.

    Raises:
        SkillFileError: Naming file and key.
    """
    return _take_field(_open_fields(path))


def load_chains(path: str | Path) -> tuple[Chain, ...]:
    """Reads a `field` block, of a field or a list, as `load_field`: its chains.

    Raises:
        SkillFileError: Naming file and key.
    """
    return take_chains(_open_fields(path))


def _open_fields(path: str | Path) -> Block:
    data = read_yaml(path, error=SkillFileError)
    block = Block(data, str(path), error=SkillFileError)
    if CHECKSUM in data:
        _check_checksum(block, data)
    return block


def is_skill_file(path: str | Path) -> bool:
    """Whether a YAML file says that it is a skill; raises SkillFileError if unread."""
    return "schema_version" in read_yaml(path, error=SkillFileError)


def certified(skill: Skill, certificate: Certificate) -> Skill:
    """Returns the skill with a certificate that was made of its field."""
    block = certificate_to_mapping(certificate, field_to_mapping(skill.field))
    return replace(skill, certificate=block)


def skill_from_result(
    result: LearningResult,
    demonstrations: Sequence[CanonicalDemonstration],
    frame: CanonicalFrame,
) -> Skill:
    """What is kept of learning: the same result gives the same skill, bit by bit."""
    return Skill(
        field=result.field,
        start=result.start,
        seed=result.config.seed,
        config=_plain(asdict(result.config)),
        demonstration_hashes=tuple(d.sha256 for d in demonstrations),
        canonical=frame,
        mean_demonstration=result.mean_demonstration,
        scale=result.scale,
        frechet=dict(result.frechet),
        certificate=certificate_to_mapping(
            result.certificate, field_to_mapping(result.field)
        ),
    )


def skill_to_mapping(skill: Skill) -> dict[str, Any]:
    """A skill as the tree of plain values its file holds, without the checksum."""
    frame = skill.canonical
    return {
        "schema_version": SCHEMA_VERSION,
        "field": field_to_mapping(skill.field),
        "start": skill.start.tolist(),
        "seed": int(skill.seed),
        "config": _plain(skill.config),
        "demonstration_hashes": list(skill.demonstration_hashes),
        "canonical": {
            "kind": frame.kind,
            "origin": frame.origin.tolist(),
            "axes": frame.axes.tolist(),
            "scales": frame.scales.tolist(),
        },
        "mean_demonstration": skill.mean_demonstration.tolist(),
        "scale": float(skill.scale),
        "frechet": _plain(skill.frechet),
        "certificate": _plain(skill.certificate),
    }


def _take_field(file: Block) -> NavigationField:
    if file.is_list("field"):
        file.fail(
            "field",
            "found a list of fields (a composed skill); "
            "this version runs skills of a single field",
        )
    (chain,) = take_chains(file)
    return chain.fields[0]


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


def _check_version(block: Block, renew: bool) -> None:
    version = block.take("schema_version", int)
    if version == SCHEMA_VERSION or (renew and version == 1):
        return
    message = f"found {version}, this version reads {SCHEMA_VERSION}"
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
