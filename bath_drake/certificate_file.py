"""A certificate as plain values, tied to the field it is about by a checksum.

The block stands in a skill file under `certificate` and is what `bath-drake certify`
prints. It holds no time: the same field gives the same block, bit by bit.
"""

import hashlib
import json
from collections.abc import Sequence
from typing import Any, TypeVar, get_args

from bath_drake.certificate.result import (
    Box,
    Cause,
    Certificate,
    Component,
    Doubt,
    Enclosure,
    Trap,
    Verdict,
)
from bath_drake.composition.result import (
    Arrival,
    ChainCertificate,
    Handover,
    whole_verdict,
)
from bath_drake.field.critical_points import Kind
from bath_drake.yaml_block import Block

FIELD_CHECKSUM = "field_checksum"

FieldBlock = dict[str, Any] | list[dict[str, Any]]
"""One field's mapping, or the list of them of a composed skill."""

_T = TypeVar("_T", bound=str)


def content_checksum(data: FieldBlock) -> str:
    """The hash of a tree of plain values, whatever the order of its keys."""
    text = json.dumps(data, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return "sha256:" + hashlib.sha256(text.encode()).hexdigest()


def certificate_to_mapping(
    certificate: Certificate, field_block: FieldBlock
) -> dict[str, Any]:
    """A certificate as a tree of plain values, without the time it took.

    Args:
        certificate: What was found of a field.
        field_block: That field, as `bath_drake.field_file.field_to_mapping` gives it.
    """
    values = _certificate_values(certificate)
    head = {key: values.pop(key) for key in ("verdict", "reason")}
    return head | {FIELD_CHECKSUM: content_checksum(field_block)} | values


def _certificate_values(certificate: Certificate) -> dict[str, Any]:
    region = certificate.region
    return {
        "verdict": certificate.verdict,
        "reason": certificate.reason,
        "region": None if region is None else float(region),
        "apart": bool(certificate.apart),
        "witness": _point(certificate.witness),
        "critical_points": [
            {
                "x": float(p.x),
                "y": float(p.y),
                "kind": p.kind,
                "eigenvalues": [float(value) for value in p.eigenvalues],
                "box": None if p.box is None else _box(p.box),
            }
            for p in certificate.critical_points
        ],
        "traps": [
            {
                "x": float(t.x),
                "y": float(t.y),
                "component": t.component,
                "start": _point(t.start),
                "box": _box(t.box),
            }
            for t in certificate.traps
        ],
        "doubts": _doubts(certificate.doubts),
        "notes": list(certificate.notes),
        "boxes": int(certificate.boxes),
    }


def take_certificate(block: Block, field_block: FieldBlock) -> Certificate:
    """The inverse of `certificate_to_mapping`; its seconds are 0.

    Args:
        block: The certificate's block of a file.
        field_block: The field that stands beside it in the file.

    Raises:
        BathDrakeError: As the block's error, naming the key that is wrong; the
            checksum's if the certificate is about another field.
    """
    _check_about(block, field_block)
    return _take_values(block)


def _take_values(block: Block) -> Certificate:
    verdict = _take_one_of(block, "verdict", get_args(Verdict))
    reason = block.take("reason", str)
    region = None if block.take_null("region") else block.take("region", float)
    witness = None if block.take_null("witness") else _take_point(block, "witness")
    points = tuple(_take_enclosure(b) for b in block.take_blocks("critical_points"))
    traps = tuple(_take_trap(b) for b in block.take_blocks("traps"))
    doubts = tuple(_take_doubt(b) for b in block.take_blocks("doubts"))
    notes = tuple(block.take_list("notes", str))
    boxes = block.take("boxes", int)
    apart = block.take("apart", bool)
    block.finish()
    return Certificate(
        verdict=verdict,
        reason=reason,
        critical_points=points,
        traps=traps,
        doubts=doubts,
        region=region,
        notes=notes,
        witness=witness,
        boxes=boxes,
        apart=apart,
    )


def chain_certificates_to_mapping(
    certificates: Sequence[ChainCertificate], field_block: FieldBlock
) -> dict[str, Any]:
    """Certificates of a skill's branches as plain values, without the time they took.

    Stages stand in the order of the fields in the block. Verdict, reason and what is
    simulated follow from stages and handovers; they are there to be read.

    Args:
        certificates: Of each branch's chain, at least one.
        field_block: These chains, by `bath_drake.field_file.chains_to_mapping`.
    """
    parts = list(enumerate(certificates))
    verdict, reason = whole_verdict(certificates)
    simulated = [text for _, part in parts for text in part.simulated]
    return {
        "verdict": verdict,
        "reason": reason,
        FIELD_CHECKSUM: content_checksum(field_block),
        "stages": [
            {"branch": b, "stage": k} | _certificate_values(stage)
            for b, part in parts
            for k, stage in enumerate(part.stages)
        ],
        "handovers": [
            {"branch": b, "stage": k} | _handover_values(handover)
            for b, part in parts
            for k, handover in enumerate(part.handovers)
        ],
        "simulated": list(dict.fromkeys(simulated)),
    }


def take_chain_certificates(
    block: Block, field_block: FieldBlock
) -> tuple[ChainCertificate, ...]:
    """The inverse of `chain_certificates_to_mapping`; all seconds are 0.

    Args:
        block: The certificate's block of a file.
        field_block: The list of fields that stands beside it in the file.

    Raises:
        BathDrakeError: As the block's error, naming the key that is wrong; the
            checksum's if the certificates are about other fields.
    """
    _check_about(block, field_block)
    said = _take_one_of(block, "verdict", get_args(Verdict))
    block.take("reason", str)
    block.take_list("simulated", str)
    stages: list[list[Certificate]] = []
    handovers: list[list[Handover]] = []
    for inner in block.take_blocks("stages"):
        branch, stage = inner.take("branch", int), inner.take("stage", int)
        if stage == 0:
            stages.append([])
            handovers.append([])
        if branch != len(stages) - 1 or stage != len(stages[branch]):
            inner.fail("stage", "branches and stages must be numbered in turn from 0")
        stages[branch].append(_take_values(inner))
    for inner in block.take_blocks("handovers"):
        branch, stage = inner.take("branch", int), inner.take("stage", int)
        if not 0 <= branch < len(stages) or stage != len(handovers[branch]):
            inner.fail("stage", "handovers must be numbered in turn from 0")
        handovers[branch].append(_take_handover(inner))
    block.finish()
    try:
        found = tuple(map(ChainCertificate, map(tuple, stages), map(tuple, handovers)))
        verdict, _ = whole_verdict(found)
    except ValueError as problem:
        block.fail("stages", str(problem))
    if said != verdict:
        block.fail(
            "verdict", f"found {said!r}, but stages and handovers say {verdict!r}"
        )
    return found


def _handover_values(handover: Handover) -> dict[str, Any]:
    return {
        "verdict": handover.verdict,
        "reason": handover.reason,
        "clearance": handover.clearance,
        "level": handover.level,
        "arrival": handover.arrival,
        "witness": _point(handover.witness),
        "doubts": _doubts(handover.doubts),
        "boxes": int(handover.boxes),
    }


def _take_handover(block: Block) -> Handover:
    verdict = _take_one_of(block, "verdict", get_args(Verdict))
    reason = block.take("reason", str)
    clearance, level = (
        None if block.take_null(key) else block.take(key, float)
        for key in ("clearance", "level")
    )
    arrival = _take_one_of(block, "arrival", get_args(Arrival))
    witness = None if block.take_null("witness") else _take_point(block, "witness")
    doubts = tuple(_take_doubt(b) for b in block.take_blocks("doubts"))
    boxes = block.take("boxes", int)
    block.finish()
    return Handover(verdict, reason, clearance, level, arrival, witness, doubts, boxes)


def _check_about(block: Block, field_block: FieldBlock) -> None:
    found = block.take(FIELD_CHECKSUM, str)
    expected = content_checksum(field_block)
    if found != expected:
        block.fail(
            FIELD_CHECKSUM,
            f"found {found[:24]!r}, but the field beside it has {expected[:24]!r}: the "
            "certificate is about another field; `bath-drake certify --renew` "
            "makes it anew",
        )


def _point(point: tuple[float, float] | None) -> dict[str, float] | None:
    return None if point is None else {"x": float(point[0]), "y": float(point[1])}


def _box(box: Box) -> dict[str, list[float]]:
    return {
        "x": [float(box.x_min), float(box.x_max)],
        "y": [float(box.y_min), float(box.y_max)],
    }


def _doubts(doubts: tuple[Doubt, ...]) -> list[dict[str, Any]]:
    return [{"cause": d.cause, "remedy": d.remedy, "box": _box(d.box)} for d in doubts]


def _take_point(block: Block, key: str) -> tuple[float, float]:
    inner = block.take_block(key)
    point = inner.take("x", float), inner.take("y", float)
    inner.finish()
    return point


def _take_box(block: Block) -> Box:
    inner = block.take_block("box")
    x, y = inner.take_list("x", float, 2), inner.take_list("y", float, 2)
    inner.finish()
    return Box(*x, *y)


def _take_enclosure(block: Block) -> Enclosure:
    x, y = block.take("x", float), block.take("y", float)
    kind = _take_one_of(block, "kind", get_args(Kind))
    low, high = block.take_list("eigenvalues", float, 2)
    box = None if block.take_null("box") else _take_box(block)
    block.finish()
    return Enclosure(x, y, kind, (low, high), box)


def _take_trap(block: Block) -> Trap:
    x, y = block.take("x", float), block.take("y", float)
    component = _take_one_of(block, "component", get_args(Component))
    start = _take_point(block, "start")
    box = _take_box(block)
    block.finish()
    return Trap(box, x, y, component, start)


def _take_doubt(block: Block) -> Doubt:
    cause = _take_one_of(block, "cause", get_args(Cause))
    doubt = Doubt(_take_box(block), cause, block.take("remedy", str))
    block.finish()
    return doubt


def _take_one_of(block: Block, key: str, allowed: tuple[_T, ...]) -> _T:
    found = block.take(key, str)
    for value in allowed:
        if value == found:
            return value
    block.fail(key, f"found {found!r}, expected one of {', '.join(allowed)}")
