"""A certificate comes back from its file as it was, about its field alone."""

import json

import pytest

from bath_drake.certificate.result import Box, Certificate, Doubt, Enclosure, Trap
from bath_drake.certificate_file import (
    certificate_to_mapping,
    content_checksum,
    take_certificate,
)
from bath_drake.errors import SkillFileError
from bath_drake.yaml_io import Block, dump_yaml, parse_yaml

FIELD = {"goal": [0.5, 0.0], "kappa": 4.0}
BOX = Box(-0.1 - 0.2, 0.1, 1 / 3, 2 / 3)
# Every kind of finding at once, as no true certificate has them.
FULL = Certificate(
    verdict="undecided",
    reason="stuck",
    critical_points=(
        Enclosure(-1.0, 1e-17, "saddle", (-2.0, 1 / 3), BOX),
        Enclosure(0.5, 0.25, "degenerate", (0.0, 1.0), None),
    ),
    traps=(
        Trap(BOX, 0.0, 0.5, "goal", (0.1, 0.2)),
        Trap(BOX, 0.0, 0.5, "pocket", (0.0, 1e-17)),
    ),
    doubts=(Doubt(BOX, "tangency", "widen the slit"),),
    region=2.5,
    apart=True,
    notes=("obstacles 0 and 1 overlap",),
    witness=(0.0, 0.5),
    boxes=1234,
    seconds=0.5,
)


def block(data):
    return Block(data, "skill.yaml", "certificate", SkillFileError)


@pytest.mark.parametrize("certificate", [FULL, Certificate("proved", "no trap")])
def test_a_certificate_comes_back_from_text_to_the_last_bit_but_its_time(certificate):
    text = dump_yaml(certificate_to_mapping(certificate, FIELD))
    back = take_certificate(block(parse_yaml(text)), FIELD)
    expected = Certificate(**(vars(certificate) | {"seconds": 0.0}))
    assert back == expected


def test_the_block_is_strict_json_too():
    mapping = certificate_to_mapping(FULL, FIELD)
    assert json.loads(json.dumps(mapping, allow_nan=False)) == mapping


def test_a_certificate_is_of_one_field_alone():
    mapping = certificate_to_mapping(FULL, FIELD)
    turned = dict(reversed(FIELD.items()))
    assert take_certificate(block(mapping), turned).verdict == "undecided"
    message = "skill.yaml: certificate.field_checksum: .* about another field"
    with pytest.raises(SkillFileError, match=message):
        take_certificate(block(mapping), FIELD | {"kappa": 4.0 + 1e-15})
    assert content_checksum(FIELD) in mapping.values()


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d.update(verdict="numeric-pass"), "verdict: found 'numeric-pass', "),
        (lambda d: d.update(region="all"), "certificate.region: found 'all'"),
        (lambda d: d.update(boxes=1.5), "certificate.boxes: found 1.5"),
        (lambda d: d.update(more=1), "more: unknown key, allowed: field_checksum, ver"),
        (lambda d: d["witness"].pop("y"), "certificate.witness.y: is missing"),
        (lambda d: d["traps"][0].update(component="hole"), "component: found 'hole'"),
        (lambda d: d["traps"][0].update(start=3), r"traps\[0\].start: found 3"),
        (lambda d: d["doubts"][0].update(cause="luck"), "cause: found 'luck'"),
        (lambda d: d["doubts"][0]["box"].update(x=[1.0]), "box.x: found 1 items"),
        (lambda d: d["critical_points"][1].update(kind="hill"), "kind: found 'hill'"),
        (lambda d: d["critical_points"][0].pop("eigenvalues"), "eigenvalues: is miss"),
    ],
)
def test_a_bad_block_is_refused_by_key(change, message):
    mapping = certificate_to_mapping(FULL, FIELD)
    change(mapping)
    with pytest.raises(SkillFileError, match=message):
        take_certificate(block(mapping), FIELD)
