"""Layers, order and places of a directed graph's nodes, for drawing it."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, order=True)
class Connection:
    """One output port feeding one input port, by names."""

    source: str
    output: str
    target: str
    input: str

    def __str__(self) -> str:
        return f"{self.source}.{self.output} -> {self.target}.{self.input}"


def forward_order(names: Iterable[str], wires: Sequence[Connection]) -> list[str]:
    """Orders systems so that few connections point back.

    The greedy heuristic of Eades, Lin and Smyth (1993), then single systems moved
    to wherever that leaves fewer connections pointing back, until none helps.
    """
    return _moved(_greedy_order(names, wires), wires)


def _greedy_order(names: Iterable[str], wires: Sequence[Connection]) -> list[str]:
    """Sinks last, sources first, else whoever has most outputs over inputs."""
    rest = sorted(names)
    first: list[str] = []
    last: list[str] = []
    while rest:
        inside = [
            w
            for w in wires
            if w.source in rest and w.target in rest and w.source != w.target
        ]
        fed = {w.target for w in inside}
        feeding = {w.source for w in inside}
        sinks = [name for name in rest if name not in feeding]
        sources = [name for name in rest if name not in fed]
        if sinks:
            last = sinks + last
            rest = [name for name in rest if name not in sinks]
        elif sources:
            first += sources
            rest = [name for name in rest if name not in sources]
        else:
            surplus = {name: 0 for name in rest}
            for wire in inside:
                surplus[wire.source] += 1
                surplus[wire.target] -= 1
            best = max(rest, key=lambda name: surplus[name])
            first.append(best)
            rest.remove(best)
    return first + last


def _moved(order: list[str], wires: Sequence[Connection]) -> list[str]:
    improved = True
    while improved:
        improved = False
        for name in list(order):
            # Passing a system on the way, a connection with it turns round.
            here = order.index(name)
            best, best_at = 0, here
            for step in (-1, 1):
                gain, at = 0, here + step
                while 0 <= at < len(order):
                    other = order[at]
                    to = sum(w.source == name and w.target == other for w in wires)
                    back = sum(w.source == other and w.target == name for w in wires)
                    gain += (to - back) if step < 0 else (back - to)
                    if gain > best:
                        best, best_at = gain, at
                    at += step
            if best > 0:
                order.remove(name)
                order.insert(best_at, name)
                improved = True
    return order


def assign_layers(order: Sequence[str], wires: Sequence[Connection]) -> dict[str, int]:
    """Longest-path layers of the forward connections; sources sit by their users."""
    place = {name: k for k, name in enumerate(order)}
    ahead = [w for w in wires if place[w.source] < place[w.target]]
    layer = dict.fromkeys(order, 0)
    for name in order:
        sources = [layer[w.source] + 1 for w in ahead if w.target == name]
        layer[name] = max(sources, default=0)
    for name in reversed(order):
        users = [layer[w.target] - 1 for w in ahead if w.source == name]
        if users and not any(w.target == name for w in ahead):
            layer[name] = min(users)
    return layer


def spread(
    wanted: Sequence[float], heights: Sequence[float], gap: float
) -> list[float]:
    """Tops of stacked boxes, nearest to those wanted (least squares), in order.

    Pooling of adjacent violators: boxes that would overlap move as one group.
    """
    offsets = np.concatenate([[0.0], np.cumsum(np.asarray(heights)[:-1] + gap)])
    groups: list[tuple[float, int]] = []
    for value in np.asarray(wanted, dtype=np.float64) - offsets:
        mean, count = float(value), 1
        while groups and groups[-1][0] > mean:
            other, size = groups.pop()
            mean = (mean * count + other * size) / (count + size)
            count += size
        groups.append((mean, count))
    tops = np.repeat([mean for mean, _ in groups], [count for _, count in groups])
    result: list[float] = (tops + offsets).tolist()
    return result
