"""What must be true of every certificate, checked by the oracle."""

import numpy as np
from basins import Root, find_minima, least_beta, polish

from bath_drake.certificate.result import Box, Certificate, Trap
from bath_drake.field.navigation import NavigationField
from bath_drake.field.rollout import RolloutStatus, rollout_ends
from bath_drake.notation import FloatArray


def free_points(
    field: NavigationField, count: int, rng: np.random.Generator
) -> FloatArray:
    """Points of free space, evenly strewn; all of those drawn that are free."""
    w = field.workspace
    q = w.centre + rng.uniform(-1.0, 1.0, (count, 2)) * w.semi_axes
    return q[least_beta(q, field) > 1e-6]


def ends_of(starts: FloatArray, field: NavigationField):
    """Statuses and ends of roll-outs, their steps a 200th of the workspace."""
    size = float(field.workspace.semi_axes.min())
    return rollout_ends(
        starts,
        field,
        step=size / 200,
        max_steps=200_000,  # in slits with small exponents guarded steps creep
        goal_tolerance=1e-6 * size,
    )


def assert_all_arrive(starts: FloatArray, field: NavigationField) -> None:
    """Every roll-out ends at the goal."""
    statuses, ends = ends_of(starts, field)
    for start, status, end in zip(starts, statuses, ends, strict=True):
        assert status is RolloutStatus.ARRIVED, (start, end, status)


def assert_is_a_trap(trap: Trap, field: NavigationField) -> None:
    """The box is free and holds a minimum, and the start leads there."""
    root = polish(trap.x, trap.y, field)
    assert root is not None
    assert root.clear > 0.0
    # A proved minimum may be flatter than the oracle calls beyond doubt: its lower
    # eigenvalue is right to about 1e-12 of the upper one.
    assert root.low > -1e-12 * root.high
    assert root.high > 0.0
    assert holds(trap.box, root)
    edges = np.linspace(0.0, 1.0, 5)
    x = trap.box.x_min + edges * (trap.box.x_max - trap.box.x_min)
    y = trap.box.y_min + edges * (trap.box.y_max - trap.box.y_min)
    lattice = np.stack(np.meshgrid(x, y), axis=-1)
    assert (least_beta(lattice, field) > 0.0).all()
    assert trap.start is not None
    away = np.hypot(trap.start[0] - root.x, trap.start[1] - root.y)
    # Short steps: where the start is near its basin's edge, long ones jump over it.
    _, ends = rollout_ends(
        np.array([trap.start]), field, step=0.002 * away, max_steps=50_000
    )
    missed = np.hypot(ends[0, 0] - root.x, ends[0, 1] - root.y)
    # Guarded steps stop where psi cannot be told to fall any more: along the flat
    # direction that is a few times 1e-8 / sqrt(low) from the minimum.
    size = float(field.workspace.semi_axes.max())
    assert holds(trap.box, root) or missed < 1e-4 * size
    assert missed < 1e-2 * size


def holds(box: Box, root: Root) -> bool:
    """Whether a box holds a root, which is known to a few units in the last place."""
    slack = 4e-15 * (abs(root.x) + abs(root.y))
    return (
        box.x_min - slack <= root.x <= box.x_max + slack
        and box.y_min - slack <= root.y <= box.y_max + slack
    )


def assert_enclosures_hold(certificate: Certificate, field: NavigationField) -> None:
    """Every enclosed critical point is where and what the certificate says."""
    for point in certificate.critical_points:
        root = polish(point.x, point.y, field)
        if point.box is None:
            continue  # a finding, not a fact
        assert root is not None
        assert point.box.holds(point.x, point.y)
        assert holds(point.box, root)
        if point.kind == "saddle":
            assert root.low < 0.0 < root.high
        elif point.kind == "minimum":
            assert root.low > -1e-12 * root.high
        else:
            assert root.high < 1e-12 * abs(root.low)


def assert_sound(
    certificate: Certificate,
    field: NavigationField,
    rng: np.random.Generator,
    starts: int = 60,
) -> None:
    """Nothing the certificate claims of a whole field is false, as far as is seen."""
    assert_enclosures_hold(certificate, field)
    if certificate.verdict == "proved":
        assert certificate.doubts == ()
        assert certificate.traps == ()
        assert least_beta(field.goal, field) > 0.0
        assert find_minima(field) == []
        assert_all_arrive(free_points(field, starts, rng), field)
    elif certificate.verdict == "refuted":
        assert certificate.witness is not None
        if certificate.traps:
            for trap in certificate.traps:
                assert_is_a_trap(trap, field)
        else:
            assert certificate.witness == tuple(field.goal)
            assert least_beta(field.goal, field) < 1e-12
    else:
        assert certificate.doubts
