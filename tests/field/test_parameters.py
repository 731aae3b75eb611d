"""A field as a vector and back."""

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given

from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.field.parameters import pack_field, parameter_size, unpack_field

finite = st.floats(-1e6, 1e6)
positive = st.floats(1e-3, 1e3)
rows = st.lists(
    st.tuples(finite, finite, positive, positive, finite, positive), max_size=5
)
fields = st.builds(
    lambda c, s, p, g, k, r: NavigationField(
        Workspace(np.array(c), np.array(s), p),
        np.array(g),
        k,
        ObstacleSet(
            np.array(r, dtype=float).reshape(-1, 6)[:, :5],
            np.array(r, dtype=float).reshape(-1, 6)[:, 5],
        ),
    ),
    st.tuples(finite, finite),
    st.tuples(positive, positive),
    st.sampled_from([2, 4, 10]),
    st.tuples(finite, finite),
    positive,
    rows,
)


@given(fields, st.integers(5, 9))
def test_packing_and_unpacking_give_the_same_field(
    field: NavigationField, room: int
) -> None:
    vector = pack_field(field, room)
    assert vector.shape == (parameter_size(room),) == (9 + 6 * room,)
    assert unpack_field(vector) == field


def _vector() -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    disc = Workspace(np.zeros(2), np.ones(2))
    obstacles = ObstacleSet(np.array([[0.0, 0.5, 0.1, 0.1, 0.0]]))
    return pack_field(NavigationField(disc, np.zeros(2), 2.0, obstacles), 2)  # type: ignore[return-value]


def test_more_obstacles_than_fit_are_refused() -> None:
    with pytest.raises(ValueError, match="at most 0 fit"):
        pack_field(unpack_field(_vector()), 0)


@pytest.mark.parametrize(
    ("index", "value", "message"),
    [(8, 3.0, "count"), (8, 0.5, "count"), (4, 2.5, "power"), (7, -1.0, "kappa")],
)
def test_impossible_vectors_are_refused(index: int, value: float, message: str) -> None:
    vector = _vector()
    vector[index] = value
    with pytest.raises(ValueError, match=message):
        unpack_field(vector)


def test_a_vector_of_the_wrong_length_is_refused() -> None:
    with pytest.raises(ValueError, match="length"):
        unpack_field(np.zeros(10))
