"""Chains come back from their `field` block as they were; a bad block by key."""

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given, settings

from bath_drake.composition.chain import Chain, Gate
from bath_drake.errors import SkillFileError
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.field_file import (
    chains_from_mapping,
    chains_to_mapping,
    field_to_mapping,
)
from bath_drake.yaml_io import dump_yaml, parse_yaml

NUMBER = st.floats(-2.0, 2.0)
POSITIVE = st.floats(0.01, 2.0)


@st.composite
def fields(draw):
    rows = draw(st.lists(st.tuples(NUMBER, NUMBER, POSITIVE, POSITIVE, NUMBER)))
    return NavigationField(
        Workspace(draw(st.tuples(NUMBER, NUMBER)), np.full(2, draw(POSITIVE))),
        np.array([draw(NUMBER), draw(NUMBER)]),
        draw(POSITIVE),
        ObstacleSet(np.reshape(rows, (-1, 5))),
    )


@st.composite
def chains(draw):
    stages = draw(st.lists(fields(), min_size=1, max_size=4))
    turns = [draw(st.floats(-4.0, 4.0)) for _ in stages[1:]]
    gates = [
        Gate(f.goal, np.array([np.cos(t), np.sin(t)]), draw(POSITIVE))
        for f, t in zip(stages, turns, strict=False)
    ]
    return Chain(tuple(stages), tuple(gates))


@settings(max_examples=20, deadline=None)
@given(st.lists(chains(), min_size=1, max_size=3))
def test_chains_come_back_from_text_to_the_last_bit(given_chains):
    text = dump_yaml({"field": chains_to_mapping(given_chains)})
    assert chains_from_mapping(parse_yaml(text)["field"]) == tuple(given_chains)


@settings(max_examples=20, deadline=None)
@given(fields())
def test_a_single_field_is_a_chain_of_one(field):
    assert chains_from_mapping(field_to_mapping(field)) == (Chain((field,)),)
    assert chains_to_mapping([Chain((field,))]) == [field_to_mapping(field)]


def two_branches():
    rim = Workspace(np.zeros(2), np.ones(2))
    field = NavigationField(rim, np.array([0.5, 0.0]), 3.0, ObstacleSet())
    gate = Gate(np.array([0.45, 0.0]), np.array([1.0, 0.0]), 0.1)
    return chains_to_mapping([Chain((field, field), (gate,)), Chain((field,))])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d.clear(), "field: found no fields"),
        (lambda d: d[0].pop("gate"), r"field\[1\].branch: found 0, expected 1: the f"),
        (lambda d: d[0].update(branch=1), r"field\[0\].branch: found 1, expected 0"),
        (lambda d: d[2].update(branch=0), r"\[2\].branch: found 0, expected 1: the fi"),
        (lambda d: d[2].pop("branch"), r"field\[2\].branch: found 0, expected 1"),
        (
            lambda d: d[1].update(gate=d[0]["gate"]),
            r"\[2\].branch: found 1, expected 0",
        ),
        (
            lambda d: d[2].update(gate=d[0]["gate"]),
            r"field\[2\].gate: found a gate, but no field follows it",
        ),
        (lambda d: d[0].update(gate=3), r"field\[0\].gate: found 3"),
        (lambda d: d[0]["gate"].pop("radius"), r"field\[0\].gate.radius: is missing"),
        (lambda d: d[0]["gate"].update(radius=0.0), r"\[0\].gate: radius must be posi"),
        (lambda d: d[0]["gate"].update(direction=[0, 0]), "direction must not be zero"),
        (lambda d: d[0]["gate"].update(width=1), r"gate.width: unknown key"),
        (lambda d: d[0]["gate"].update(centre=[0, 0]), "goal of field 0 is not within"),
        (lambda d: d[1].update(gates=None), r"field\[1\].gates: unknown key"),
        (lambda d: d[1].update(kappa=-1), r"field\[1\]: kappa must be"),
        (lambda d: d.append(3), r"field\[3\]: found 3, expected a mapping"),
    ],
)
def test_a_bad_list_is_refused_by_key(change, message):
    data = two_branches()
    assert len(chains_from_mapping(data)) == 2
    change(data)
    with pytest.raises(SkillFileError, match=message):
        chains_from_mapping(data, "skill.yaml")


def test_a_gate_may_be_null_where_there_is_none():
    data = two_branches()
    data[1]["gate"] = None
    assert chains_from_mapping(data) == chains_from_mapping(two_branches())
