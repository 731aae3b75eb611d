"""Checks a velocity of the canonical point: finite, in free space, slow and smooth.

Only ever scaled, never turned: what passes is along the flow that was asked for.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from bath_drake.field._boundaries import compiled, crosses, min_beta, quadratic_forms
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet
from bath_drake.notation import FloatArray
from bath_drake.safety.limits import GuardLimits
from bath_drake.safety.reasons import Reason

# A slower command than this, 1/s, is none; further off the goal than that, in N, the
# flow asks for none at a critical point alone.
STILL, THERE = 1e-6, 1e-3
# Beyond any meaning, and of a finite square: m, and 1/s.
_HUGE = 1e6
# How often a step that leaves free space is halved before it is held.
_HALVINGS = 5


@dataclass(frozen=True, eq=False)
class GuardedWorld:
    """A world in the kernels' form, as it is and with the margin around everything.

    Attributes:
        goal: (2,) in N.
        workspace: As it is.
        forms: Of all obstacles, (Q, 6).
        areas: Of the restricted areas alone, (A, 6).
        inner_workspace: Smaller by at least the margin.
        wide_forms: Of all obstacles, larger by at least the margin.
    """

    goal: FloatArray
    workspace: FloatArray
    forms: FloatArray
    areas: FloatArray
    inner_workspace: FloatArray
    wide_forms: FloatArray


@lru_cache(maxsize=32)
def guarded_world(
    field: NavigationField, areas: ObstacleSet, margin: float
) -> GuardedWorld:
    """The world of a field's obstacles and of restricted areas.

    What is more than nothing inside the inner workspace and outside the wide forms is
    at least `margin` from every boundary; the converse holds for circles alone.

    Args:
        field: The field without the areas.
        areas: The restricted areas.
        margin: In N, >= 0.

    Raises:
        ValueError: If the margin leaves nothing of the workspace.
    """
    every = field.obstacles + areas
    inner = field.workspace.as_array()
    # It is convex and holds the disc of its smaller semi-axis: scaled by this, it is
    # everywhere the margin away from its rim.
    share = 1.0 - margin / inner[2:4].min()
    if not share > 0.0:
        raise ValueError(
            f"margin must be less than the workspace's semi-axes {inner[2:4].tolist()},"
            f" got {margin}"
        )
    inner[2:4] *= share
    return GuardedWorld(
        goal=field.goal,
        workspace=field.workspace.as_array(),
        forms=_forms(every),
        areas=_forms(areas),
        inner_workspace=inner,
        wide_forms=_forms(_widened(every, margin)),
    )


def _forms(obstacles: ObstacleSet) -> FloatArray:
    # numba compiles anew for read-only arrays: plain copies.
    return quadratic_forms(obstacles.theta.copy(), obstacles.powers.copy())


def _widened(obstacles: ObstacleSet, margin: float) -> ObstacleSet:
    """Ellipses that hold every point within the margin of the given ones."""
    if margin == 0.0:
        return obstacles
    # Of an ellipse and a disc, for every p > 0, the sum lies within the ellipse with
    # squared semi-axes (1 + 1/p) a^2 + (1 + p) m^2; this p makes their sum least.
    theta = obstacles.theta.copy()
    squares = theta[:, 2:4] ** 2
    p = np.sqrt(squares.mean(axis=1, keepdims=True)) / margin
    theta[:, 2:4] = np.sqrt((1.0 + 1.0 / p) * squares + (1.0 + p) * margin**2)
    return ObstacleSet(theta, obstacles.powers)


@dataclass(frozen=True, eq=False)
class CheckedVelocity:
    """What may be done of a command.

    Attributes:
        velocity: (2,) in 1/s, finite; zero unless `reason` is NONE.
        reason: Why it must be held, or NONE.
        limited: Whether it was scaled.
    """

    velocity: FloatArray
    reason: Reason
    limited: bool = False


def check_canonical_command(
    velocity: ArrayLike,
    point: ArrayLike,
    last: ArrayLike,
    *,
    world: GuardedWorld,
    half_extents: ArrayLike,
    condition_number: float,
    dt: float,
    limits: GuardLimits,
) -> CheckedVelocity:
    """Checks a velocity of the canonical point.

    From free space with the margin, the point stays in it along the whole step and
    along the way it takes to brake after it; from within the margin it may only go
    out. A step that does not is halved until it does, and held if it never does.

    Slowing down is always allowed: the point is a number and stops at once. What is
    limited is speeding up and turning; a turn too sharp for its speed stops first.

    Args:
        velocity: v_NQ (2,), 1/s.
        point: p_NQ (2,), where it starts.
        last: (2,) the velocity emitted last, 1/s, finite.
        world: Where it moves.
        half_extents: (2,) of the body, m: N to the skin.
        condition_number: Of the nozzle's Jacobian; slows the motion as it grows.
        dt: The step, s.
        limits: What to keep to.
    """
    v = np.asarray(velocity, dtype=np.float64)
    p = np.asarray(point, dtype=np.float64)
    extents = np.asarray(half_extents, dtype=np.float64)
    if not all(a.shape == (2,) for a in (v, p, extents)):
        return _held(Reason.COMMAND_NOT_FINITE)
    (vx, vy), (x, y) = v.tolist(), p.tolist()
    told = (vx, vy, x, y, condition_number)
    sizes = all(0.0 < extent < _HUGE for extent in extents.tolist())
    if not (sizes and all(map(math.isfinite, told))):
        return _held(Reason.COMMAND_NOT_FINITE)
    if len(world.areas) and min_beta(x, y, _EVERYWHERE, world.areas) <= 0.0:
        return _held(Reason.AREA_ENTERED)
    if min_beta(x, y, world.workspace, world.forms) <= 0.0:
        return _held(Reason.POINT_NOT_FREE)
    speed = math.hypot(vx, vy)
    if speed > _HUGE:
        return _held(Reason.COMMAND_JUMP)
    if speed < STILL:
        away = math.dist((x, y), world.goal.tolist())
        return _held(Reason.TRAPPED if away > THERE else Reason.NONE)
    share = _condition_share(condition_number, limits)
    before = np.asarray(last, dtype=np.float64)
    share = _speed_share(share, v, before, extents, dt, limits)
    if share < STILL / speed:  # a turn that stops first, or a singular arm
        return CheckedVelocity(np.zeros(2), Reason.NONE, limited=True)
    free = _free_share(
        x,
        y,
        share * vx,
        share * vy,
        dt,
        limits.canonical.acceleration,
        world.workspace,
        world.forms,
        world.inner_workspace,
        world.wide_forms,
    )
    if free == 0.0:
        return _held(Reason.CLEARANCE)
    share *= free
    # Above rounding, below what anybody would call slower.
    return CheckedVelocity(share * v, Reason.NONE, limited=share < 1.0 - 1e-9)


# A rim that is never met.
_EVERYWHERE = np.array([0.0, 0.0, 1e200, 1e200, 2.0])


def _held(reason: Reason) -> CheckedVelocity:
    return CheckedVelocity(np.zeros(2), reason)


def _condition_share(condition_number: float, limits: GuardLimits) -> float:
    """1 up to where it slows, falling to 0 where it stops."""
    slow, stop = limits.joints.condition_slow, limits.joints.condition_stop
    return min(max((stop - condition_number) / (stop - slow), 0.0), 1.0)


def _speed_share(
    share: float,
    v: FloatArray,
    last: FloatArray,
    extents: FloatArray,
    dt: float,
    limits: GuardLimits,
) -> float:
    """The largest share of `v` within both speeds and the change allowed since `last`.

    Of what the speeds allow it is no more than `share`. 0 if only less than nothing of
    `v` is within the change: then it stops first.
    """
    canonical = limits.canonical
    speed, along_skin = math.hypot(*v.tolist()), math.hypot(*(extents * v).tolist())
    share *= min(1.0, canonical.speed / speed, canonical.skin_speed / along_skin)
    # |s v - last| <= change, as a quadratic in s.
    before = math.hypot(*last.tolist())
    change = canonical.acceleration * dt
    along = float(v @ last) / speed
    room = change * change - (before * before - along * along)
    if room < 0.0:
        return 0.0
    return min(share, max((along + math.sqrt(room)) / speed, 0.0))


@compiled
def _free_share(
    x: float,
    y: float,
    vx: float,
    vy: float,
    dt: float,
    acceleration: float,
    workspace: FloatArray,
    forms: FloatArray,
    inner_workspace: FloatArray,
    wide_forms: FloatArray,
) -> float:
    """1, 1/2, 1/4, ... of the velocity that leads into no margin; 0 if none does."""
    speed = math.hypot(vx, vy)
    now = min_beta(x, y, inner_workspace, wide_forms)
    share = 1.0
    for _ in range(_HALVINGS):
        # The step, and the way to brake after it.
        reach = share * (dt + 0.5 * share * speed / acceleration)
        dx = reach * vx
        dy = reach * vy
        then = min_beta(x + dx, y + dy, inner_workspace, wide_forms)
        if now > 0.0:
            free = then > 0.0 and not crosses(x, y, dx, dy, wide_forms)
        else:
            free = (
                then > now
                and min_beta(x + dx, y + dy, workspace, forms) > 0.0
                and not crosses(x, y, dx, dy, forms)
            )
        if free:
            return share
        share *= 0.5
    return 0.0
