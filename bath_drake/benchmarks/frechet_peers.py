"""Other packages that know the discrete Fréchet distance."""

import importlib.metadata
from collections.abc import Callable
from dataclasses import dataclass

from bath_drake.notation import FloatArray

Distance = Callable[[FloatArray, FloatArray], float]


@dataclass(frozen=True)
class Peer:
    """A package, and how to call it.

    Attributes:
        package: Its name in the index.
        function: Imports it and returns its distance.
        install: What installs it.
    """

    package: str
    function: Callable[[], Distance]
    install: str

    @property
    def version(self) -> str:
        """Its version, '' if it is not installed."""
        try:
            return importlib.metadata.version(self.package)
        except importlib.metadata.PackageNotFoundError:
            return ""

    def load(self) -> Distance | str:
        """Its distance; if it is missing, a line that says so and what to do."""
        try:
            return self.function()
        except ImportError as problem:
            return f"missing ({problem.name}): {self.install}"


def _frechetlib() -> Distance:
    from frechetlib.discrete_frechet import discrete_frechet

    return lambda a, b: float(discrete_frechet(a, b)[0])


def _tslearn() -> Distance:
    from tslearn.metrics import frechet

    return lambda a, b: float(frechet(a, b))


def _traj_dist_rs() -> Distance:
    from traj_dist_rs import discret_frechet

    return lambda a, b: float(discret_frechet(a, b, "euclidean").distance)


def _similaritymeasures() -> Distance:
    from similaritymeasures import frechet_dist

    return lambda a, b: float(frechet_dist(a, b))


PEERS = (
    # It asks for numba < 0.59 and numpy < 2, but runs with later ones.
    Peer("frechetlib", _frechetlib, "pip install --no-deps frechetlib"),
    Peer("tslearn", _tslearn, "pip install tslearn"),
    Peer("traj-dist-rs", _traj_dist_rs, "pip install traj-dist-rs"),
    Peer("similaritymeasures", _similaritymeasures, "pip install similaritymeasures"),
)
# The last is here because tests trust it; it is two orders slower.
TO_BEAT = ("frechetlib", "tslearn", "traj-dist-rs")
