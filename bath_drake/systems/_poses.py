"""Rigid transforms from plain lists and arrays.

Drake takes any sequence of three numbers for a position; its stubs do not.
"""

from typing import Any

from pydrake.math import RigidTransform, RotationMatrix


def at(position: Any, rotation: RotationMatrix | None = None) -> RigidTransform:
    """Returns the pose with origin `position` (3,), m, and `rotation`, or none."""
    return RigidTransform(RotationMatrix() if rotation is None else rotation, position)


def rotation_from(matrix: Any) -> RotationMatrix:
    """Returns the rotation nearest to a (3, 3) matrix that is one but for rounding."""
    return RotationMatrix.ProjectToRotationMatrix(matrix)
