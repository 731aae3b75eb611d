"""A chain as a vector and back."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from made_up_skill import crossing_chain

from bath_drake.composition.chain import Chain
from bath_drake.composition.parameters import (
    chain_parameter_size,
    pack_chain,
    unpack_chain,
)


@given(st.integers(1, 3), st.integers(3, 6), st.integers(1, 4))
def test_packing_and_unpacking_give_the_same_chain(stages, room, obstacles):
    whole = crossing_chain()
    chain = Chain(whole.fields[:stages], whole.gates[: stages - 1])
    vector = pack_chain(chain, room, obstacles)
    assert vector.shape == (1 + room * (14 + 6 * obstacles),)
    assert len(vector) == chain_parameter_size(room, obstacles)
    assert unpack_chain(vector, room) == chain


def test_more_than_fits_is_refused():
    with pytest.raises(ValueError, match="3 stages, at most 2 fit"):
        pack_chain(crossing_chain(), 2, 4)
    with pytest.raises(ValueError, match="1 obstacles, at most 0 fit"):
        pack_chain(crossing_chain(), 3, 0)
    with pytest.raises(ValueError, match="max_stages must be >= 1"):
        chain_parameter_size(0, 4)


@pytest.mark.parametrize("count", [0.0, 4.0, 1.5, -1.0])
def test_an_impossible_number_of_stages_is_refused(count):
    vector = pack_chain(crossing_chain(), 3, 2)
    vector[0] = count
    with pytest.raises(ValueError, match=r"must be whole and in 1..3"):
        unpack_chain(vector, 3)


def test_a_vector_of_the_wrong_length_is_refused():
    with pytest.raises(ValueError, match="length must be"):
        unpack_chain(pack_chain(crossing_chain(), 3, 2), 4)


def test_a_gate_that_does_not_hold_its_goal_is_refused():
    vector = pack_chain(crossing_chain(), 3, 2)
    # The radius of the first gate is the last number of the first stage.
    vector[14 + 6 * 2] = 1e-3
    with pytest.raises(ValueError, match="not within its gate"):
        unpack_chain(vector, 3)
