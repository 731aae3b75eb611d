"""A chain of fields and the gates between them (sequential composition).

Each field's goal but the last lies within its gate, a half-disc; the motion follows a
field until it is in the field's gate and then, for good, the next. Where every field
is proved and every gate lies in the free space of the next and is crossed by its flow,
almost every start in the first field's free space reaches the last goal (after
Burridge, Rizzi and Koditschek, Sequential composition of dynamically dexterous robot
behaviors, 1999; here the funnels' mouths are the proved fields' whole free spaces).
See docs/certificate.md.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from bath_drake.composition.similarity import Similarity
from bath_drake.field.navigation import NavigationField
from bath_drake.notation import BoolArray, FloatArray


@dataclass(frozen=True, eq=False)
class Gate:
    """The half-disc {|q - centre| <= radius, (q - centre) . direction >= 0}.

    Attributes:
        centre: Middle of its straight side, shape (2,), in N.
        direction: Along which the motion passes the straight side, shape (2,); made a
            unit vector.
        radius: In units of N, positive.

    Raises:
        ValueError: A value is not of that kind.
    """

    centre: FloatArray
    direction: FloatArray
    radius: float

    def __post_init__(self) -> None:
        for name in ("centre", "direction"):
            value = np.array(getattr(self, name), dtype=np.float64)
            if value.shape != (2,) or not np.isfinite(value).all():
                raise ValueError(f"{name} must be two finite numbers, got {value}")
            if name == "direction":
                length = float(np.hypot(*value))
                if not length > 0.0:
                    raise ValueError("direction must not be zero")
                # What is read from a file is a unit vector already: keep its bits.
                if abs(length - 1.0) > 1e-12:
                    value = value / length
            value.setflags(write=False)
            object.__setattr__(self, name, value)
        if not 0.0 < float(self.radius) < np.inf:
            raise ValueError(f"radius must be positive and finite, got {self.radius}")
        object.__setattr__(self, "radius", float(self.radius))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Gate):
            return NotImplemented
        return bool(np.array_equal(self.as_array(), other.as_array()))

    def __hash__(self) -> int:
        return hash(self.as_array().tobytes())

    def as_array(self) -> FloatArray:
        """(centre x, y, direction x, y, radius), the kernels' form."""
        return np.array([*self.centre, *self.direction, self.radius])

    def holds(self, q: ArrayLike) -> BoolArray:
        """Whether points (..., 2) are in it, shape (...)."""
        away = np.asarray(q, dtype=np.float64) - self.centre
        ahead = away @ self.direction >= 0.0
        return np.asarray(ahead & ((away**2).sum(axis=-1) <= self.radius**2))

    def outline(self, count: int = 32) -> FloatArray:
        """Its boundary, shape (count + 2, 2), closed."""
        across = np.array([-self.direction[1], self.direction[0]])
        t = np.linspace(-0.5 * np.pi, 0.5 * np.pi, count + 1)[:, None]
        arc = np.cos(t) * self.direction + np.sin(t) * across
        points = self.centre + self.radius * arc
        return np.concatenate([points, points[:1]])

    def moved(self, by: Similarity) -> "Gate":
        """The gate where a similarity takes it."""
        if by.is_identity:
            return self
        direction = by.directions(self.direction) / by.scale
        return Gate(by.points(self.centre), direction, by.scale * self.radius)


@dataclass(frozen=True, eq=False)
class Chain:
    """Fields that are followed in turn; a single field is a chain of one.

    Attributes:
        fields: K >= 1 of them.
        gates: K - 1; the motion leaves field k once it is in gate k.

    Raises:
        ValueError: The numbers do not fit, or a field's goal is not within its gate.
    """

    fields: tuple[NavigationField, ...]
    gates: tuple[Gate, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "fields", tuple(self.fields))
        object.__setattr__(self, "gates", tuple(self.gates))
        if not self.fields or len(self.gates) != len(self.fields) - 1:
            raise ValueError(
                f"{len(self.fields)} fields need {max(0, len(self.fields) - 1)} gates, "
                f"got {len(self.gates)}"
            )
        for k, (field, gate) in enumerate(zip(self.fields, self.gates, strict=False)):
            if not gate.holds(field.goal):
                raise ValueError(f"the goal of field {k} is not within its gate")

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Chain):
            return NotImplemented
        return self.fields == other.fields and self.gates == other.gates

    def __hash__(self) -> int:
        return hash((self.fields, self.gates))

    def __len__(self) -> int:
        return len(self.fields)

    @property
    def goal(self) -> FloatArray:
        """The last field's, shape (2,)."""
        return self.fields[-1].goal

    @property
    def obstacle_count(self) -> int:
        """Virtual obstacles of all fields together."""
        return sum(len(field.obstacles) for field in self.fields)

    def stage_at(self, q: ArrayLike, stage: int) -> int:
        """The stage that follows ``stage`` at a point (2,): later if in its gates."""
        while stage < len(self.gates) and self.gates[stage].holds(q):
            stage += 1
        return stage

    def rest(self, stage: int) -> "Chain":
        """What is left of it from a stage on: the same object every time."""
        return self if stage == 0 else self._rests[stage - 1]

    @cached_property
    def _rests(self) -> tuple["Chain", ...]:
        later = range(1, len(self))
        return tuple(Chain(self.fields[k:], self.gates[k:]) for k in later)

    def moved(self, by: tuple[Similarity, ...]) -> "Chain":
        """The chain with each field, and its gate, moved by a similarity of its own."""
        if len(by) != len(self.fields):
            raise ValueError(f"{len(self.fields)} similarities needed, got {len(by)}")
        fields = tuple(m.field(f) for m, f in zip(by, self.fields, strict=True))
        gates = tuple(g.moved(m) for m, g in zip(by, self.gates, strict=False))
        return Chain(fields, gates)
