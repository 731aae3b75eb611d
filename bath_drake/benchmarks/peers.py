"""Other methods under the same protocol.

The paper's learner is `bath_drake.learning.paper`. The movement primitives are those of
the library movement_primitives; both follow a clock, at the demonstrations' own timing,
so they can do what no field of position can, and neither proves anything.
"""

import numpy as np

from bath_drake.benchmarks.methods import (
    blended_mean,
    learner,
    mean_demonstration,
    straight_line,
)
from bath_drake.benchmarks.reproduction import POINTS, Learned, Method, Shape
from bath_drake.errors import BathDrakeError
from bath_drake.learning.config import LearnerConfig
from bath_drake.notation import FloatArray

DMP_WEIGHTS = 50
PROMP_WEIGHTS = 30
# Of start and goal. Less is worse in-sample and, where a start is outside what few
# demonstrations span, far worse held out; ten times more helps that, but not the rest.
VARIANCE = 1e-5
PAPER = "paper"
# Half of what it breeds by default: a benchmark is to be a matter of minutes.
PAPER_GENERATIONS = 40
# What the extra `bench` holds: an installed checkout is not asked for its extras.
INSTALL = "pip install movement-primitives pytransform3d"


def peers(quick: bool = False) -> dict[str, Method]:
    """Every other method by name; ``quick`` as in `LearnerConfig.quick`.

    Raises:
        BathDrakeError: The library is missing.
    """
    try:
        import movement_primitives.dmp
        import movement_primitives.promp  # noqa: F401
    except ImportError as problem:
        raise BathDrakeError(
            f"--peers: the package {problem.name} is missing, install it with: "
            f"{INSTALL}"
        ) from None
    full = LearnerConfig(method="paper", generations=PAPER_GENERATIONS)
    return {
        PAPER: learner(LearnerConfig.quick(method="paper") if quick else full),
        "line": straight_line,
        "mean": mean_demonstration,
        "blended_mean": blended_mean,
        "dmp": dynamic_movement_primitive,
        "promp": probabilistic_movement_primitive,
    }


def dynamic_movement_primitive(shape: Shape) -> Learned:
    """A DMP of the mean demonstration over time, with smooth scaling."""
    from movement_primitives.dmp import DMP

    shares, demonstrations = _over_time(shape)
    duration = float(np.mean([d.times[-1] for d in shape.demonstrations]))
    primitive = DMP(
        n_dims=2,
        execution_time=duration,
        dt=duration / (POINTS - 1),
        n_weights_per_dim=DMP_WEIGHTS,
        smooth_scaling=True,
    )
    primitive.imitate(shares * duration, demonstrations.mean(axis=0))

    def roll_out(start: FloatArray) -> FloatArray:
        primitive.configure(start_y=start, goal_y=np.zeros(2))
        _, path = primitive.open_loop()
        return np.asarray(path)

    return Learned(roll_out)


def probabilistic_movement_primitive(shape: Shape) -> Learned:
    """A ProMP, conditioned on the start and on the goal."""
    from movement_primitives.promp import ProMP

    shares, demonstrations = _over_time(shape)
    primitive = ProMP(n_dims=2, n_weights_per_dim=PROMP_WEIGHTS)
    primitive.imitate([shares] * len(demonstrations), demonstrations)

    def roll_out(start: FloatArray) -> FloatArray:
        there = primitive.condition_position(start, VARIANCE * np.eye(2), t=0.0)
        there = there.condition_position(np.zeros(2), VARIANCE * np.eye(2), t=1.0)
        return np.asarray(there.mean_trajectory(shares))

    return Learned(roll_out)


def _over_time(shape: Shape) -> tuple[FloatArray, FloatArray]:
    """Equal shares of time, shape (200,), and where each demonstration is then."""
    shares = np.linspace(0.0, 1.0, POINTS)
    sampled = [
        np.stack(
            [np.interp(shares * d.times[-1], d.times, p) for p in d.points.T], axis=-1
        )
        for d in shape.demonstrations
    ]
    return shares, np.array(sampled)
