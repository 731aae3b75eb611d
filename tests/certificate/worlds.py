"""Worlds whose verdict follows from a reason that can be checked by hand."""

import math
from dataclasses import dataclass

import numpy as np

from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet, Workspace

Row = list[float]
Point = tuple[float, float]

PROVED = frozenset({"proved"})
REFUTED = frozenset({"refuted"})
# Where the truth is known and arithmetic of finite precision may fail to show it.
AT_BEST_PROVED = frozenset({"proved", "undecided"})
AT_BEST_REFUTED = frozenset({"refuted", "undecided"})


@dataclass(frozen=True)
class World:
    """A field, the verdicts it may get and why.

    Attributes:
        field: The world.
        verdicts: Those allowed; any other is a defect.
        why: The reason, in a sentence.
        minima: All besides the goal, or None where they are not listed.
        saddles: All, or None where they are not listed.
        pocket: Whether a trap lies in a part that the obstacles close off.
        cause: What an undecided certificate must name, if given.
        witness: The point that a refuted one must name, if given.
    """

    field: NavigationField
    verdicts: frozenset[str]
    why: str
    minima: tuple[Point, ...] | None = None
    saddles: tuple[Point, ...] | None = None
    pocket: bool = False
    cause: str | None = None
    witness: Point | None = None


def make(
    kappa: float,
    *rows: Row,
    exponents: list[float] | None = None,
    goal: Point = (3.0, 0.0),
    centre: Point = (0.0, 0.0),
    semi_axes: Point = (5.0, 5.0),
    power: int = 2,
) -> NavigationField:
    """A field; rows are (centre x, centre y, a, b, angle)."""
    return NavigationField(
        Workspace(np.array(centre), np.array(semi_axes), power),
        np.array(goal),
        kappa,
        ObstacleSet(
            np.array(rows, dtype=np.float64).reshape(-1, 5),
            None if exponents is None else np.array(exponents),
        ),
    )


def ring(x: float, y: float, radius: float, disc: float, count: int) -> list[Row]:
    """Discs whose centres lie on a circle."""
    angles = 2.0 * np.pi * np.arange(count) / count
    return [
        [x + radius * math.cos(t), y + radius * math.sin(t), disc, disc, 0.0]
        for t in angles
    ]


_TILTED = [0.0, 0.0, 1.0, 0.7, 0.3]
_FIVE = [[0, 0], [0, 2], [0, -2], [-2, 1], [-2, -1]]
_CONVEX = (
    "beta_0 is concave, so (q - q_d).grad beta_0 < beta_0 and psi grows at least "
    "like (2 kappa - 1) ln |q - q_d| along every ray from the goal"
)

# Four whose critical points are known to five decimals.
KNOWN = {
    "one disc": World(
        make(4, [0, 0, 1, 1, 0]),
        PROVED,
        "a disc bends more than any circle about the goal that touches it behind",
        minima=(),
        saddles=((-1.67172, 0.0),),
    ),
    "broadside ellipse": World(
        make(10, [-0.5, 0, 0.2, 1.6, 0]),
        REFUTED,
        "an 8:1 ellipse broadside is flatter than the circle about the goal (1.5)",
        minima=((-0.97537, 0.0),),
        saddles=((-0.55205, -1.97946), (-0.55205, 1.97946)),
    ),
    "overlapping discs across the way": World(
        make(10, [0, 0.6, 0.8, 0.8, 0], [0, -0.6, 0.8, 0.8, 0]),
        REFUTED,
        "the notch between them faces away from the goal",
        minima=((-1.06166, 0.0),),
    ),
    "overlapping discs along the way": World(
        make(10, [0.6, 0, 0.8, 0.8, 0], [-0.6, 0, 0.8, 0.8, 0]),
        PROVED,
        "what faces away from the goal is one disc; the notches are slid past",
        minima=(),
        saddles=((-1.74547, 0.0),),
    ),
}

EMPTY = {
    "no obstacles": World(make(2), PROVED, _CONVEX, (), ()),
    "no obstacles, kappa one": World(make(1), PROVED, _CONVEX, (), ()),
    "no obstacles, kappa a thousand": World(make(1000), PROVED, _CONVEX, (), ()),
    "superellipse of power 4": World(make(2, power=4), PROVED, _CONVEX, (), ()),
    "superellipse of power 8, off centre": World(
        make(2, centre=(10, -7), semi_axes=(2, 1), power=8, goal=(11.5, -7.5)),
        PROVED,
        _CONVEX,
        (),
        (),
    ),
    "an obstacle wholly outside": World(
        make(10, [7, 0, 1, 1, 0]),
        PROVED,
        "free space is the whole disc; the obstacle's push is far below the pull",
        (),
        (),
    ),
}

PASSING = {
    "kappa one": World(
        make(1, [0, 0, 1, 1, 0]),
        PROVED,
        "the rim alone keeps the far side from falling outwards; one saddle there",
        minima=(),
    ),
    "kappa a thousand": World(
        make(1000, [0, 0, 1, 1, 0], [-2, 2, 0.5, 0.5, 0], [0, -3, 0.7, 0.7, 0]),
        PROVED,
        "circles pass at every large kappa, and these are far apart",
        minima=(),
    ),
    "five discs": World(
        make(60, *[[x, y, 0.5, 0.5, 0] for x, y in _FIVE]),
        PROVED,
        "circles with wide gaps and a large kappa: one saddle behind each",
        minima=(),
    ),
    "a gap of 2 % of the radius": World(
        make(20, [-0.5, 0.85, 0.8, 0.8, 0], [-0.5, -0.85, 0.8, 0.8, 0]),
        PROVED,
        "a point in the gap is pulled through before the discs squeeze it back (1.13)",
        minima=(),
    ),
    "an obstacle across the rim": World(
        make(10, [0, 4.9, 0.8, 0.8, 0]),
        PROVED,
        "what is left of it is a bump on the rim, which is no hole",
        minima=(),
        saddles=(),
    ),
    "a large obstacle across the rim, behind": World(
        make(10, [-4.5, 0, 2, 2, 0]),
        PROVED,
        "its far side lies outside: no point of free space is behind it",
        minima=(),
        saddles=(),
    ),
    "an obstacle that covers the centre": World(
        make(10, [0, 0, 2, 2, 0]),
        PROVED,
        "the paper needs no free centre: one disc, one saddle behind it",
        minima=(),
    ),
    "an ellipse along the way": World(
        make(10, [0, 0, 1.6, 0.2, 0]),
        PROVED,
        "what faces away from the goal is its sharpest point",
        minima=(),
    ),
    "a needle along the way": World(
        make(10, [0, 0, 1.5, 1e-3, 0]),
        PROVED,
        "the same, a thousand times thinner",
        minima=(),
    ),
    "twice the same ellipse": World(
        make(10, _TILTED, _TILTED),
        PROVED,
        "psi is that of one ellipse with exponent two",
        minima=(),
    ),
    "twice the same ellipse, other exponents": World(
        make(10, _TILTED, _TILTED, exponents=[0.5, 1.5]),
        PROVED,
        "psi is that of one ellipse with exponent two",
        minima=(),
    ),
    "one ellipse with exponent two": World(
        make(10, _TILTED, exponents=[2.0]),
        PROVED,
        "what the two worlds above amount to",
        minima=(),
    ),
    "one obstacle inside another": World(
        make(10, [0, 0, 1, 1, 0], [0.2, 0.1, 0.5, 0.5, 0]),
        PROVED,
        "a hidden obstacle adds a smooth push to that of the outer one",
        minima=(),
    ),
    "one obstacle touching another from within": World(
        make(10, [0, 0, 1, 1, 0], [0.5, 0, 0.5, 0.5, 0]),
        PROVED,
        "the boundaries share a point and its normal: still one smooth hole",
        minima=(),
    ),
    "a small exponent": World(
        make(2, [0, 0, 1, 1, 0], exponents=[1e-3]),
        PROVED,
        "the saddle lies close behind the disc, at about w / kappa of its radius",
        minima=(),
    ),
    "an obstacle of a millionth": World(
        make(10, [0, 0, 1e-6, 1e-6, 0]),
        PROVED,
        "its saddle is about 3 / (kappa - 1) behind it whatever its size: ln beta is"
        " 2 ln r up to a constant",
        minima=(),
    ),
    "a goal beside an obstacle": World(
        make(10, [1.999, 0, 1, 1, 0]),
        PROVED,
        "free space near the goal stays free however narrow",
        minima=(),
    ),
    "a goal beside the rim": World(
        make(10, [0, 0, 1, 1, 0], goal=(4.999, 0)),
        PROVED,
        "the same at the rim",
        minima=(),
    ),
    "two ellipses in a superellipse": World(
        make(20, [0, 0, 1, 0.5, 1], [-2, 2, 0.5, 0.5, 0], power=4, goal=(3, 3)),
        PROVED,
        "a round and a mild ellipse, far apart: one saddle each",
        minima=(),
    ),
    "an ellipse in an off-centre superellipse": World(
        make(
            20,
            [10, -7, 0.3, 0.2, 0.5],
            centre=(10, -7),
            semi_axes=(2, 1),
            power=8,
            goal=(11.5, -7.5),
        ),
        PROVED,
        "one mild ellipse, one saddle",
        minima=(),
    ),
    "a wedge that opens towards the goal": World(
        make(20, [-0.5, 1, 0.4, 1.2, -0.5], [-0.5, -1, 0.4, 1.2, 0.5]),
        PROVED,
        "two ellipses meet in a point that faces away from the goal",
        minima=(),
    ),
}

TRAPPING = {
    "a gap of 0.2 % of the radius": World(
        make(20, [-0.5, 0.805, 0.8, 0.8, 0], [-0.5, -0.805, 0.8, 0.8, 0]),
        REFUTED,
        "the discs squeeze a point back before it is pulled through (1.13)",
    ),
    "discs that touch, across the way": World(
        make(10, [0, 1, 1, 1, 0], [0, -1, 1, 1, 0]),
        REFUTED,
        "the cusp behind them closes, the pull leads in and beta pushes out",
        minima=((-0.73954, 0.0),),
    ),
    "a wedge that opens away from the goal": World(
        make(20, [-0.5, 1, 0.4, 1.2, 0.5], [-0.5, -1, 0.4, 1.2, -0.5]),
        REFUTED,
        "a corner to run into",
        minima=((-0.43559, 0.0),),
    ),
    "a broadside ellipse at kappa 1.2": World(
        make(1.2, [0, 0, 0.2, 1.6, 0]),
        REFUTED,
        "an 8:1 ellipse broadside traps at every kappa in 1.2..30 (1.5)",
    ),
    "a broadside ellipse at kappa 30": World(
        make(30, [0, 0, 0.2, 1.6, 0]),
        REFUTED,
        "an 8:1 ellipse broadside traps at every kappa in 1.2..30 (1.5)",
    ),
    "a wire across the way": World(
        make(10, [0, 0, 1e-3, 1.5, 0]),
        REFUTED,
        "a needle broadside is flat",
    ),
    "a needle askew": World(
        make(10, [0, 0, 1e-3, 1.5, math.pi / 4]),
        REFUTED,
        "the goal lies in the needle's evolute",
    ),
    "a broadside ellipse of a hundred-millionth": World(
        make(10, [0, 0, 1e-8, 8e-8, 0]),
        REFUTED,
        "far off ln beta is ln(u^2/a^2 + v^2/b^2), of any size: a trap at about 3 /"
        " (kappa - 1) behind it while b^2 / a^2 > kappa",
        minima=((-0.33170, 0.0),),
    ),
    "a closed ring": World(
        make(10, *ring(-1.5, 0, 1.5, 0.7, 8)),
        REFUTED,
        "psi is finite within the ring and infinite on it: it has a minimum there",
        minima=((-0.84849, 0.0),),
        pocket=True,
    ),
    "a wall through the workspace": World(
        make(10, *[[0, y - 4.5, 0.7, 0.7, 0] for y in range(10)]),
        REFUTED,
        "the far half is a component of its own and holds a minimum of its own",
        minima=((-3.93457, 0.0),),
        pocket=True,
    ),
    "a goal in an obstacle": World(
        make(10, [3, 0.1, 0.5, 0.5, 0]),
        REFUTED,
        "the goal is not in free space",
        witness=(3.0, 0.0),
    ),
    "a goal outside the workspace": World(
        make(10, [0, 0, 1, 1, 0], goal=(6, 0)),
        REFUTED,
        "the goal is not in free space",
        witness=(6.0, 0.0),
    ),
    "a goal outside that an obstacle covers too": World(
        make(10, [6, 0, 0.5, 0.5, 0], goal=(6, 0)),
        REFUTED,
        "beta is a product of two negative factors: positive, and still not free",
        witness=(6.0, 0.0),
    ),
    "a goal in two obstacles": World(
        make(10, [3, 0.1, 0.5, 0.5, 0], [3, -0.1, 0.5, 0.5, 0]),
        REFUTED,
        "beta is a product of two negative factors: positive, and still not free",
        witness=(3.0, 0.0),
    ),
    "a goal on a boundary": World(
        make(10, [2, 0, 1, 1, 0]),
        AT_BEST_REFUTED,
        "beta(q_d) = 0 exactly, which intervals cannot tell from nearly",
        witness=(3.0, 0.0),
        cause="tangency",
    ),
    "a goal on the rim": World(
        make(10, [0, 0, 1, 1, 0], goal=(5, 0)),
        AT_BEST_REFUTED,
        "beta_0(q_d) = 0 exactly, which intervals cannot tell from nearly",
        witness=(5.0, 0.0),
        cause="tangency",
    ),
    "no free space at all": World(
        make(10, [0, 0, 7, 7, 0]),
        REFUTED,
        "the obstacle covers the workspace, the goal with it",
        witness=(3.0, 0.0),
    ),
}

BORDERLINE = {
    "discs that touch, along the way": World(
        make(10, [1, 0, 1, 1, 0], [-1, 0, 1, 1, 0]),
        AT_BEST_PROVED,
        "the cusps open sideways and are slid past; at the point of contact both"
        " betas vanish with opposite normals",
        minima=(),
        cause="tangency",
    ),
    "discs that touch, off the symmetric line": World(
        make(10, [0, 0, 1, 1, 0], [-2, 0, 1, 1, 0]),
        AT_BEST_PROVED,
        "the same elsewhere",
        minima=(),
        cause="tangency",
    ),
    "a disc that touches the rim": World(
        make(10, [0, 4, 1, 1, 0]),
        AT_BEST_PROVED,
        "both cusps lead out of themselves on the way to the goal",
        minima=(),
        cause="tangency",
    ),
    "a goal a billionth off a boundary": World(
        make(10, [2.0 - 1e-9, 0, 1, 1, 0]),
        AT_BEST_PROVED,
        "free, but by 1e-9 only",
        minima=(),
    ),
    "a goal on a boundary up to rounding": World(
        make(10, [0, 0, 1, 1, 0], goal=(math.cos(1.0), math.sin(1.0))),
        AT_BEST_REFUTED | AT_BEST_PROVED,
        "1e-17 inside or outside; no claim can be told wrong, but none may crash",
    ),
    "a hair along the way": World(
        make(10, [0, 0, 1.5, 1e-6, 0]),
        AT_BEST_PROVED,
        "a sharp point behind; free space bends within 1e-12 there",
        minima=(),
    ),
    "a vanishing exponent": World(
        make(2, [0, 0, 1, 1, 0], exponents=[1e-9]),
        AT_BEST_PROVED,
        "the saddle lies 1e-9 behind the disc",
        minima=(),
    ),
    "an obstacle of a ten-billionth": World(
        make(10, [0, 0, 1e-10, 1e-10, 0]),
        AT_BEST_PROVED,
        "its saddle is as far off as that of a large one",
        minima=(),
    ),
}

WORLDS = KNOWN | EMPTY | PASSING | TRAPPING | BORDERLINE
