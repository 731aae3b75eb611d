"""`bath-drake bench frechet`: how fast the discrete Fréchet distance is.

Two kinds of curves from fixed seeds: unrelated random walks, where no pair of points
can be left out, and two takes of one stroke, each at its own pace, which is what a
learner compares. All is measured on one core, plain numpy and peers in the same run;
the fastest of many calls counts, over five pairs of curves each.
"""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from bath_drake.benchmarks.figures import Figure, Progress, Report, Row, Settings
from bath_drake.benchmarks.frechet_peers import PEERS, TO_BEAT, Distance, Peer
from bath_drake.benchmarks.timing import best_seconds, one_core, seconds
from bath_drake.learning.frechet import discrete_frechet, discrete_frechet_gradient
from bath_drake.notation import FloatArray

# From the issue that asks for it: microseconds, and times faster than any peer.
TARGET = 80.0
TARGET_RATIO = 2.0

_PAIRS = 5
_Pairs = Sequence[tuple[FloatArray, FloatArray]]


def run(settings: Settings, progress: Progress, effort: float = 0.3) -> Report:
    """Measures for about `effort` seconds each; with peers, each of them as well."""
    kinds = {"unrelated": walks, "alike": takes}
    own: dict[str, float] = {}
    figures: list[Figure] = []
    with one_core():
        for done, (kind, make) in enumerate(kinds.items()):
            progress(f"curves that are {kind}", 0.5 * done / len(kinds))
            for n in (100, 200, 1000):
                name = f"frechet_{n}_{kind}"
                pairs = make(n)
                mine = microseconds(discrete_frechet, pairs, effort)
                plain = microseconds(plain_frechet, pairs, effort)
                target = TARGET if n == 200 else None
                figures.append(Figure(name, mine, "us", target))
                figures.append(Figure(f"{name}_speedup", plain / mine, "x numpy"))
                if n == 200:
                    own[kind] = mine
            graded = microseconds(discrete_frechet_gradient, make(200), effort)
            figures.append(Figure(f"frechet_gradient_200_{kind}", graded, "us"))
        rows: list[Row] = []
        if settings.peers:
            curves = {kind: make(200) for kind, make in kinds.items()}
            for done, peer in enumerate(PEERS):
                progress(peer.package, 0.5 + 0.5 * done / len(PEERS))
                rows.append(_measure(peer, curves, effort))
            figures += _ratios(own, rows)
    progress("done", 1.0)
    return Report(figures, rows)


def walks(n: int) -> list[tuple[FloatArray, FloatArray]]:
    """Pairs of random walks of n points."""
    rng = np.random.default_rng(1)
    steps = rng.normal(size=(_PAIRS, 2, n, 2))
    return [(a, b) for a, b in steps.cumsum(axis=2)]


def takes(n: int) -> list[tuple[FloatArray, FloatArray]]:
    """Pairs of takes of a wavy stroke about 2 long, of n points each."""
    rng = np.random.default_rng(2)

    def take() -> FloatArray:
        share = np.linspace(0.0, 1.0, n)
        share = share + rng.normal(scale=0.03) * np.sin(2.0 * np.pi * share)
        clean = np.stack([1.5 * share, 0.3 * np.sin(3.0 * np.pi * share)], axis=-1)
        # A hand strays slowly, by a centimetre or two if the stroke is in metres.
        turns = np.outer(share, [2.0, 3.0]) + rng.uniform(size=2)
        return clean + rng.normal(scale=0.02, size=2) * np.sin(2.0 * np.pi * turns)

    return [(take(), take()) for _ in range(_PAIRS)]


def plain_frechet(a: FloatArray, b: FloatArray) -> float:
    """The distance in plain numpy, an anti-diagonal of the table at a time."""
    n, m = len(a), len(b)
    squares = ((a[:, None] - b[None, ::-1]) ** 2).sum(axis=-1)
    last, now = np.full(n + 1, np.inf), np.full(n + 1, np.inf)
    last[0] = 0.0  # what the first pair of points comes from
    for k in range(n + m - 1):
        low, high = max(0, k - m + 1), min(k, n - 1) + 1
        before = np.minimum(now[low:high], now[low + 1 : high + 1])
        before = np.minimum(before, last[low:high])
        last, now = now, np.full(n + 1, np.inf)
        now[low + 1 : high + 1] = np.maximum(squares.diagonal(m - 1 - k), before)
    return float(np.sqrt(now[n]))


def microseconds(
    function: Callable[[FloatArray, FloatArray], object], pairs: _Pairs, effort: float
) -> float:
    """Microseconds of a call, the best of as many as the effort in seconds allows."""

    def all_pairs() -> None:
        for a, b in pairs:
            function(a, b)

    all_pairs()
    repeats = round(effort / max(seconds(all_pairs), 1e-9))
    best = best_seconds(all_pairs, max(2, min(repeats, 1000)))
    return 1e6 * best / len(pairs)


def _measure(peer: Peer, curves: Mapping[str, _Pairs], effort: float) -> Row:
    """One peer's times, and by what share its distances differ from ours."""
    row: dict[str, str | float] = {"peer": peer.package, "version": peer.version}
    distance = peer.load()
    for kind in curves:
        row[f"{kind}_us"] = np.nan
    row["differs_by"] = np.nan
    row["note"] = distance if isinstance(distance, str) else ""
    if not isinstance(distance, str):
        for kind, pairs in curves.items():
            row[f"{kind}_us"] = microseconds(distance, pairs, effort)
        row["differs_by"] = max(
            _difference(distance, a, b) for pairs in curves.values() for a, b in pairs
        )
    return row


def _difference(distance: Distance, a: FloatArray, b: FloatArray) -> float:
    return abs(distance(a, b) / discrete_frechet(a, b) - 1.0)


def _ratios(own: Mapping[str, float], rows: Sequence[Row]) -> list[Figure]:
    """The fastest time to beat in units of ours; unknown while one is missing."""
    rivals = [row for row in rows if row["peer"] in TO_BEAT]
    figures = []
    for kind, mine in own.items():
        times = [float(row[f"{kind}_us"]) for row in rivals]
        name = f"frechet_200_{kind}_against_peers"
        # Not the built-in: np.min keeps NaN.
        ratio = float(np.min(times)) / mine
        figures.append(Figure(name, ratio, "x fastest", TARGET_RATIO, "at least"))
    return figures
