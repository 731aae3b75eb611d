"""What can be chosen about learning."""

from dataclasses import dataclass, field
from typing import Literal

from bath_drake.learning.cost import ValidityMargins
from bath_drake.learning.seeding import MAX_OBSTACLES

Method = Literal["auto", "paper"]
Fields = Literal["auto", "one", "many"]


@dataclass(frozen=True)
class LearnerConfig:
    """How a skill is learned.

    Raises:
        ValueError: A value is out of its range.
    """

    method: Method = "auto"
    """'auto': genetic search with multiple shooting as local descent.
    'paper': the paper's own learner (see `bath_drake.learning.paper`), which the seeds,
    the target and the margins do not concern."""
    fields: Fields = "auto"
    """'one': a single field. 'many': a chain of fields, of one where that is best.
    'auto': whichever is cheaper by the criterion of `judge.Judged.price`."""
    obstacles: int | None = None
    """How many ellipses a single field has, 0 to 12, which then is what is learned;
    None finds how many are needed."""
    seed: int = 0
    """Seed of the one random generator."""
    population: int | None = None
    """Members of a generation, at least 4; None: 24 ('auto') or 50 ('paper')."""
    generations: int | None = None
    """How many follow the first; None: 12 ('auto') or 80 ('paper')."""
    seeds: int = 150
    """Places and shapes among which an obstacle more is chosen."""
    tries: int = 4
    """Members that descend for each number of obstacles of a chain's stage."""
    target: float = 0.025
    """C, over the strokes' scale, at which a single field is good enough and 'auto'
    breeds no further generation; up to twice that where demonstrations are spread."""
    workspace_radius: float = 2.0
    """Radius of the round workspace, in N, about its origin."""
    points: int = 160
    """Points to which every demonstration is resampled."""
    margins: ValidityMargins = field(default_factory=ValidityMargins)
    """Distances that keep the field valid."""

    def __post_init__(self) -> None:
        if self.method not in ("auto", "paper"):
            raise ValueError(f"method must be 'auto' or 'paper', got {self.method!r}")
        if self.fields not in ("auto", "one", "many"):
            raise ValueError(
                f"fields must be 'auto', 'one' or 'many', got {self.fields!r}"
            )
        if self.fields == "many" and (
            self.method == "paper" or self.obstacles is not None
        ):
            raise ValueError(
                "fields must be 'auto' or 'one' for the paper's method and for a given "
                "number of obstacles, got 'many'"
            )
        if self.obstacles is not None and not 0 <= self.obstacles <= MAX_OBSTACLES:
            raise ValueError(
                f"obstacles must be in 0..{MAX_OBSTACLES}, got {self.obstacles}"
            )
        if self.population is not None and self.population < 4:
            raise ValueError(f"population must be >= 4, got {self.population}")
        if self.generations is not None and self.generations < 0:
            raise ValueError(f"generations must be >= 0, got {self.generations}")
        if self.seeds < 1:
            raise ValueError(f"seeds must be >= 1, got {self.seeds}")
        if self.tries < 1:
            raise ValueError(f"tries must be >= 1, got {self.tries}")
        if self.points < 20:
            raise ValueError(f"points must be >= 20, got {self.points}")
        if not self.workspace_radius > 0.0:
            raise ValueError(
                f"workspace_radius must be positive, got {self.workspace_radius}"
            )

    @property
    def composes(self) -> bool:
        """Whether chains of fields are tried."""
        return self.method == "auto" and self.obstacles is None and self.fields != "one"

    @classmethod
    def quick(cls, seed: int = 0, method: Method = "auto") -> "LearnerConfig":
        """A few seconds' effort, for tests and first looks; expect a worse fit."""
        return cls(
            method=method,
            seed=seed,
            # The paper's members are drawn evenly: a good first guess is rare.
            population=24 if method == "paper" else 8,
            generations=20 if method == "paper" else 2,
            seeds=40,
            tries=2,
            target=0.05,
            points=100,
        )
