"""Walks to the edge between proved and refuted, where an error is likeliest.

Two random worlds of opposite verdicts are joined by a straight line of worlds, and the
change is bisected. On its proved side no minimum may be left where one was just before;
on its refuted side the traps must be real though nearly gone.
"""

import numpy as np
import pytest
from basins import find_minima, least_beta, polish
from checks import assert_is_a_trap
from random_worlds import random_world

from bath_drake.certificate.certify import certify
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet

# Boxes: ten times what these worlds need away from the edge.
_EFFORT = 50_000


def _between(
    one: NavigationField, two: NavigationField, share: float
) -> NavigationField:
    def mix(a, b):
        return (1.0 - share) * a + share * b

    n = min(len(one.obstacles), len(two.obstacles))
    obstacles = ObstacleSet(
        mix(one.obstacles.theta[:n], two.obstacles.theta[:n]),
        mix(one.obstacles.powers[:n], two.obstacles.powers[:n]),
    )
    goal = mix(one.goal, two.goal)
    kappa = float(np.exp(mix(np.log(one.kappa), np.log(two.kappa))))
    return NavigationField(one.workspace, goal, kappa, obstacles)


def _walk(seed: int, index: int) -> tuple[float, int]:
    """How near the edge was decided, and how many worlds were looked at."""
    rng = np.random.default_rng([seed, index])
    kind = ("disjoint", "overlapping", "rim-cut")[index % 3]
    ends = [random_world(kind, rng) for _ in range(2)]
    shares = [0.0, 1.0]
    first, last = (
        certify(_between(*ends, share), budget=_EFFORT).verdict for share in shares
    )
    if {first, last} != {"proved", "refuted"}:
        return 1.0, 2
    near: list[tuple[float, float]] = []
    looked_at = 2
    while shares[1] - shares[0] > 1e-13:
        middle = 0.5 * (shares[0] + shares[1])
        field = _between(*ends, middle)
        found = certify(field, budget=_EFFORT)
        looked_at += 1
        for trap in found.traps:
            assert_is_a_trap(trap, field)
        if found.verdict == "refuted":
            near += [(t.x, t.y) for t in found.traps]
        if found.verdict == "proved":
            assert find_minima(field, 65) == []
            for x, y in near:
                if least_beta([x, y], field) > 0.0:
                    root = polish(x, y, field)
                    assert root is None or not root.is_minimum
        if found.verdict == "undecided":
            assert found.doubts
            break
        shares[0 if found.verdict == first else 1] = middle
    return shares[1] - shares[0], looked_at


@pytest.mark.slow
def test_on_the_way_to_an_edge_no_verdict_is_false() -> None:
    # Traps of this line lie in a flat valley, past which roll-outs creep for long.
    width, looked_at = _walk(31, 1)
    assert looked_at > 20
    # Folds in the open are decided until the force at stake is of rounding's size.
    assert width < 1e-6


@pytest.mark.exhaustive
def test_on_the_way_to_many_edges_no_verdict_is_false() -> None:
    walks = [_walk(32, i) for i in range(240)]
    widths = [width for width, looked_at in walks if looked_at > 2]
    assert len(widths) >= 30
    assert np.median(widths) < 1e-6
