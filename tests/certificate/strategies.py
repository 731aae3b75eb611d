"""Strategies that draw valid worlds outright; none is filtered."""

import math

import hypothesis.strategies as st
import numpy as np
from random_worlds import CELLS, leave_free
from worlds import make

from bath_drake.field.navigation import NavigationField

share = st.floats(-1.0, 1.0)
kappas = st.floats(0.0, math.log10(150.0)).map(lambda e: 10.0**e)
large_kappas = st.floats(1.5, math.log10(150.0)).map(lambda e: 10.0**e)
exponents = st.just(1.0) | st.floats(-1.0, 0.6).map(lambda e: 10.0**e)


@st.composite
def disjoint_worlds(draw, most: int = 8, kappas=large_kappas) -> NavigationField:
    """Mild ellipses in cells of their own, the goal in another one.

    Each lies at least 0.05 within its square of side 1.5, so that gaps are 0.1 or
    more (2 % of the radius).
    """
    cells = draw(
        st.lists(
            st.integers(0, len(CELLS) - 1), min_size=1, max_size=most + 1, unique=True
        )
    )
    goal = CELLS[cells[0]] + 0.5 * np.array([draw(share), draw(share)])
    rows, weights = [], []
    for cell in CELLS[cells[1:]]:
        a = draw(st.floats(0.1, 0.7))
        b = a * draw(st.floats(0.5, 1.0))
        room = 0.7 - a
        x, y = cell + room * np.array([draw(share), draw(share)])
        rows.append([x, y, a, b, draw(st.floats(-4.0, 4.0))])
        weights.append(draw(exponents))
    return make(
        draw(kappas), *rows, exponents=weights, goal=(float(goal[0]), float(goal[1]))
    )


@st.composite
def any_worlds(draw, most: int = 6) -> NavigationField:
    """Obstacles anywhere, overlapping and across the rim; the goal is free."""
    goal = (draw(st.floats(-3.0, 3.0)), draw(st.floats(-3.0, 3.0)))
    row = st.tuples(
        st.floats(-5.0, 5.0),
        st.floats(-5.0, 5.0),
        st.floats(0.1, 2.0),
        st.floats(0.1, 2.0),
        st.floats(-4.0, 4.0),
        exponents,
    )
    rows = np.array(draw(st.lists(row, max_size=most))).reshape(-1, 6)
    # An ellipse centred on the goal cannot be shrunk off it: moved first.
    close = np.hypot(*(rows[:, :2] - goal).T) < 0.2
    rows[close, 0] += 0.5
    theta = leave_free(rows[:, :5], np.array(goal), 0.05)
    return make(draw(kappas), *theta.tolist(), exponents=rows[:, 5].tolist(), goal=goal)


worlds = disjoint_worlds() | any_worlds()


def moved(
    field: NavigationField,
    *,
    scale: float = 1.0,
    angle: float = 0.0,
    mirrored: bool = False,
    shift: tuple[float, float] = (0.0, 0.0),
) -> tuple[NavigationField, np.ndarray]:
    """The same world in a disc mirrored, turned, scaled and shifted; and the matrix."""
    c, s = math.cos(angle), math.sin(angle)
    matrix = scale * np.array([[c, -s], [s, c]])
    if mirrored:
        matrix = matrix @ np.diag([1.0, -1.0])
    theta = field.obstacles.theta.copy()
    theta[:, :2] = theta[:, :2] @ matrix.T + shift
    theta[:, 2:4] *= scale
    theta[:, 4] = angle + (-theta[:, 4] if mirrored else theta[:, 4])
    centre = matrix @ field.workspace.centre + shift
    goal = matrix @ field.goal + shift
    radius = scale * float(field.workspace.semi_axes[0])
    other = make(
        field.kappa,
        *theta.tolist(),
        exponents=field.obstacles.powers.tolist(),
        goal=(float(goal[0]), float(goal[1])),
        centre=(float(centre[0]), float(centre[1])),
        semi_axes=(radius, radius),
    )
    return other, matrix
