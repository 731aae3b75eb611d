"""A field as one vector of fixed length, for a Drake numeric parameter."""

from collections.abc import Callable
from typing import Any

import numpy as np

from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.notation import FloatArray

_HEAD = 9
_ROW = 6


def parameter_size(max_obstacles: int) -> int:
    """Length of the vector that holds up to ``max_obstacles`` obstacles."""
    if max_obstacles < 0:
        raise ValueError(f"max_obstacles must be >= 0, got {max_obstacles}")
    return _HEAD + _ROW * max_obstacles


def pack_field(field: NavigationField, max_obstacles: int) -> FloatArray:
    """Writes a field into a vector of length 9 + 6 ``max_obstacles``.

    In order: workspace centre x and y, semi-axes, power; goal x and y; kappa;
    the number of obstacles; then (centre x, y, a, b, angle, exponent) for each,
    zeros behind.

    Raises:
        ValueError: The field has more obstacles than fit.
    """
    count = len(field.obstacles)
    vector = np.zeros(parameter_size(max_obstacles))
    if count > max_obstacles:
        raise ValueError(
            f"the field has {count} obstacles, at most {max_obstacles} fit"
        )
    vector[:5] = field.workspace.as_array()
    vector[5:7] = field.goal
    vector[7] = field.kappa
    vector[8] = count
    rows = vector[_HEAD : _HEAD + _ROW * count].reshape(count, _ROW)
    rows[:, :5] = field.obstacles.theta
    rows[:, 5] = field.obstacles.powers
    return vector


def split_parameters(
    vector: Any, value: Callable[[Any], float] = float
) -> tuple[Any, Any, int]:
    """Splits such a vector, of scalars of any kind, without looking into them.

    Args:
        vector: Shape (9 + 6 n,).
        value: Gives a scalar as a float; asked for the two whole numbers.

    Returns:
        The first 9 scalars, the rows (count, 6) of the obstacles, and the power.

    Raises:
        ValueError: The length, the count or the power cannot be.
    """
    vector = np.asarray(vector)
    room, left = divmod(vector.size - _HEAD, _ROW)
    if vector.ndim != 1 or room < 0 or left:
        raise ValueError(f"length must be 9 + 6 n, got shape {vector.shape}")
    count = float(value(vector[8]))
    if not count.is_integer() or not 0 <= count <= room:
        raise ValueError(f"the count must be a whole number in 0..{room}, got {count}")
    power = float(value(vector[4]))
    if not power.is_integer():
        raise ValueError(f"the workspace's power must be whole, got {power}")
    rows = vector[_HEAD : _HEAD + _ROW * int(count)].reshape(int(count), _ROW)
    return vector[:_HEAD], rows, int(power)


def unpack_field(vector: FloatArray) -> NavigationField:
    """Reads back what `pack_field` wrote, bit by bit.

    Raises:
        ValueError: The length or the count cannot be, or a value is invalid.
    """
    head, rows, power = split_parameters(np.asarray(vector, dtype=np.float64))
    return NavigationField(
        workspace=Workspace(head[:2], head[2:4], power),
        goal=head[5:7],
        kappa=float(head[7]),
        obstacles=ObstacleSet(rows[:, :5], rows[:, 5]),
    )
