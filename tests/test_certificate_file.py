"""A certificate comes back from its file as it was, about its field alone."""

import json

import pytest

from bath_drake.certificate.result import Box, Certificate, Doubt, Enclosure, Trap
from bath_drake.certificate_file import (
    certificate_to_mapping,
    chain_certificates_to_mapping,
    content_checksum,
    take_certificate,
    take_chain_certificates,
)
from bath_drake.composition.result import ChainCertificate, Handover
from bath_drake.errors import SkillFileError
from bath_drake.yaml_block import Block
from bath_drake.yaml_io import dump_yaml, parse_yaml

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


PROVED = Certificate("proved", "no trap", boxes=3)
HANDOVER = Handover("proved", "free", 0.1 / 3, -1e-17, "every", None, (), 12)
STUCK = Handover(
    "refuted", "in obstacle 1", witness=(0.1, 1 / 3), doubts=FULL.doubts, boxes=1
)
CHAINS = (
    ChainCertificate((PROVED, FULL, PROVED), (HANDOVER, STUCK), 0.5),
    ChainCertificate((PROVED,)),
)
FIELDS = [FIELD, FIELD, FIELD, FIELD]


def test_certificates_of_chains_come_back_but_for_their_times():
    text = dump_yaml(chain_certificates_to_mapping(CHAINS, FIELDS))
    back = take_chain_certificates(block(parse_yaml(text)), FIELDS)
    timeless = ChainCertificate(
        (PROVED, Certificate(**(vars(FULL) | {"seconds": 0.0})), PROVED),
        (HANDOVER, STUCK),
    )
    assert back == (timeless, CHAINS[1])
    assert back[0].verdict == "refuted"
    assert back[0].witness == FULL.witness
    assert back[1].reason == "no trap"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d.update(verdict="proved"), "verdict: found 'proved', but stages"),
        (lambda d: d["stages"].clear(), "stages: there is no chain|handovers must be"),
        (lambda d: d["handovers"].pop(), "stages: 3 stages need 2 handovers, got 1"),
        (lambda d: d["stages"][1].update(stage=2), r"stages\[1\].stage: branches and"),
        (lambda d: d["stages"][3].update(branch=0), r"stages\[3\].stage: branches and"),
        (lambda d: d["handovers"][0].update(branch=2), r"\[0\].stage: handovers must"),
        (lambda d: d["handovers"][0].update(arrival="some"), "arrival: found 'some'"),
        (lambda d: d["handovers"][0].update(clearance="x"), "clearance: found 'x'"),
        (lambda d: d["handovers"][1].update(more=1), r"\[1\].more: unknown key"),
        (lambda d: d.update(more=1), "certificate.more: unknown key"),
    ],
)
def test_a_bad_block_of_a_chain_is_refused_by_key(change, message):
    mapping = chain_certificates_to_mapping(CHAINS, FIELDS)
    change(mapping)
    with pytest.raises(SkillFileError, match=message):
        take_chain_certificates(block(mapping), FIELDS)


def test_a_chain_s_certificate_is_of_its_fields_alone():
    mapping = chain_certificates_to_mapping(CHAINS, FIELDS)
    with pytest.raises(SkillFileError, match=r"field_checksum: .* about another field"):
        take_chain_certificates(block(mapping), FIELDS[:3])
