"""A Drake Diagram drawn as SVG: its systems, and every connection between them.

A layered drawing: what feeds what goes from left to right; feedback, found as a
small set of edges whose removal leaves no cycle, runs below everything in another
colour. Needs no graph drawing program.
"""

import itertools
from collections import defaultdict
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field
from html import escape
from typing import Any

import numpy as np
from pydrake.systems.framework import Diagram

from bath_drake.diagrams.graph_layout import (
    Connection,
    assign_layers,
    forward_order,
    spread,
)

_ROW, _TITLE, _PAD = 17, 28, 8
_LETTER = 6.6  # width of a letter of a port's name, pixels
_GAP_X, _GAP_Y = 80, 22
_DUMMY = 12  # height kept free for a connection that passes a layer
_LANE, _MARGIN = 11, 24
_SWEEPS = 24
_FORWARD, _FEEDBACK = "#5f6c7b", "#d7301f"
_STYLE = (
    "text{font-family:system-ui,'Segoe UI','Helvetica Neue','DejaVu Sans',sans-serif;"
    "font-size:11.5px;fill:#1d2733}"
    ".name{font-size:13px;font-weight:600;text-anchor:middle}"
    ".output{text-anchor:end}"
    "rect{fill:#f4f7fa;stroke:#8d9aa8;stroke-width:1.2}"
    f".connection{{fill:none;stroke:{_FORWARD};stroke-width:1.4}}"
    f".feedback{{stroke:{_FEEDBACK}}}"
)

_Item = Hashable  # a system's name, or (system, port, layer) where a port's way passes
_Neighbours = dict[_Item, dict[_Item, None]]


def connections(diagram: Diagram) -> list[Connection]:
    """Returns all connections inside a Diagram, sorted."""
    wires: Any = diagram.connection_map()
    found = []
    for (target, input_index), (source, output_index) in wires.items():
        output = source.get_output_port(output_index).get_name()
        name = target.get_input_port(input_index).get_name()
        found.append(Connection(source.get_name(), output, target.get_name(), name))
    return sorted(found)


def wiring_lines(diagram: Diagram) -> list[str]:
    """Returns the sorted lines 'a.port -> b.port' of a Diagram."""
    return [str(connection) for connection in connections(diagram)]


@dataclass
class _Block:
    """A system's box: the connected ports, and where the box lies."""

    name: str
    inputs: list[str] = field(default_factory=list)
    outputs: list[str] = field(default_factory=list)
    x: float = 0.0
    y: float = 0.0

    @property
    def height(self) -> float:
        return _TITLE + _ROW * max(len(self.inputs), len(self.outputs), 0) + _PAD

    @property
    def width(self) -> float:
        ports = max(map(len, self.inputs), default=0)
        ports += max(map(len, self.outputs), default=0)
        return max(_LETTER * ports + 40.0, 8.0 * len(self.name) + 24.0)

    def port_y(self, ports: list[str], name: str) -> float:
        return self.y + _TITLE + _ROW * (ports.index(name) + 0.5)


def draw_block_diagram(diagram: Diagram) -> str:
    """Returns the SVG text of a Diagram; its text can be selected and searched."""
    names = [system.get_name() for system in diagram.GetSystems()]
    return _Drawing(diagram.get_name(), names, connections(diagram)).svg()


class _Drawing:
    """Places boxes and connections, then writes them."""

    def __init__(
        self, title: str, names: Sequence[str], wires: Sequence[Connection]
    ) -> None:
        self._title = title
        self._wires = list(wires)
        order = forward_order(names, wires)
        self._layer = assign_layers(order, wires)
        place = {name: k for k, name in enumerate(order)}
        self._back = [place[w.source] >= place[w.target] for w in self._wires]
        self._blocks = {name: _Block(name) for name in order}
        for wire in self._wires:
            outputs = self._blocks[wire.source].outputs
            if wire.output not in outputs:
                outputs.append(wire.output)
            self._blocks[wire.target].inputs.append(wire.input)
        count = max(self._layer.values(), default=0) + 1
        self._rows: list[list[_Item]] = [[] for _ in range(count)]
        for name in order:
            self._rows[self._layer[name]].append(name)
        self._chains = [self._chain(k) for k in range(len(self._wires))]
        self._top: dict[_Item, float] = {}
        self._sort_rows()
        self._place_columns()
        self._place_rows()
        self._sort_ports()

    def _chain(self, index: int) -> list[_Item]:
        """What a forward connection visits, one item a layer; none for feedback."""
        wire = self._wires[index]
        if self._back[index]:
            return []
        first, last = self._layer[wire.source], self._layer[wire.target]
        passed: list[_Item] = []
        for layer in range(first + 1, last):
            # Connections from one port to the same layer share their way.
            item: _Item = (wire.source, wire.output, layer)
            if item not in self._rows[layer]:
                self._rows[layer].append(item)
            passed.append(item)
        return [wire.source, *passed, wire.target]

    def _neighbours(self) -> tuple[_Neighbours, _Neighbours]:
        # Dictionaries as ordered sets: the drawing must not depend on hashes.
        left: _Neighbours = defaultdict(dict)
        right: _Neighbours = defaultdict(dict)
        for chain in self._chains:
            for a, b in itertools.pairwise(chain):
                right[a][b] = None
                left[b][a] = None
        return left, right

    def _sort_rows(self) -> None:
        """Orders each layer by the barycentres of its neighbours."""
        left, right = self._neighbours()
        rank: dict[_Item, float] = {}
        for row in self._rows:
            rank.update({item: k / max(1, len(row)) for k, item in enumerate(row)})
        for sweep in range(_SWEEPS):
            rows = self._rows if sweep % 2 == 0 else self._rows[::-1]
            near = left if sweep % 2 == 0 else right
            for row in rows:
                centre = {
                    item: float(np.mean([rank[n] for n in near[item]] or [rank[item]]))
                    for item in row
                }
                row.sort(key=lambda item: centre[item])
                rank.update({item: (k + 0.5) / len(row) for k, item in enumerate(row)})

    def _height(self, item: _Item) -> float:
        return self._blocks[item].height if isinstance(item, str) else _DUMMY

    def _place_columns(self) -> None:
        x = float(_MARGIN + _GAP_X / 2)
        self._column: list[tuple[float, float]] = []
        for row in self._rows:
            blocks = [self._blocks[item] for item in row if isinstance(item, str)]
            width = max((block.width for block in blocks), default=0.0)
            for block in blocks:
                block.x = x + (width - block.width) / 2.0
            self._column.append((x, x + width))
            x += width + _GAP_X
        self._width = x - _GAP_X / 2 + _MARGIN

    def _place_rows(self) -> None:
        """Moves boxes to the height of what they are connected to."""
        left, right = self._neighbours()
        top = self._top
        for row in self._rows:
            heights = [self._height(item) for item in row]
            top.update(zip(row, spread([0.0] * len(row), heights, _GAP_Y), strict=True))
        for sweep in range(_SWEEPS):
            for row in self._rows if sweep % 2 == 0 else self._rows[::-1]:
                heights = [self._height(item) for item in row]
                wanted = []
                for item, height in zip(row, heights, strict=True):
                    near = left[item] | right[item]
                    middles = [top[n] + self._height(n) / 2.0 for n in near]
                    own = top[item] + height / 2.0
                    wanted.append(float(np.mean(middles or [own])) - height / 2.0)
                top.update(zip(row, spread(wanted, heights, _GAP_Y), strict=True))
        shift = 2.2 * _MARGIN - min(top.values(), default=0.0)
        for item in top:
            top[item] += shift
            if isinstance(item, str):
                self._blocks[item].y = top[item]
        self._floor = max((top[i] + self._height(i) for i in top), default=0.0)

    def _sort_ports(self) -> None:
        """Orders ports by where their connections come from or go to."""
        sources: dict[tuple[str, str], float] = {}
        targets: dict[tuple[str, str], list[float]] = defaultdict(list)
        for wire, chain in zip(self._wires, self._chains, strict=True):
            before = self._top[chain[-2]] if chain else self._floor
            after = self._top[chain[1]] if chain else self._floor
            sources[wire.target, wire.input] = before
            targets[wire.source, wire.output].append(after)
        for name, block in self._blocks.items():
            block.inputs.sort(key=lambda port, n=name: sources[n, port])  # type: ignore[misc]
            block.outputs.sort(
                key=lambda port, n=name: float(np.mean(targets[n, port]))  # type: ignore[misc]
            )

    def svg(self) -> str:
        """Writes it all."""
        lanes = iter(range(len(self._wires)))
        paths = [self._path(k, lanes) for k in range(len(self._wires))]
        height = self._floor + _LANE * (sum(self._back) + 2) + _MARGIN
        parts = [
            '<?xml version="1.0" encoding="UTF-8"?>',
            f'<svg xmlns="http://www.w3.org/2000/svg" width="{self._width:.0f}" '
            f'height="{height:.0f}" viewBox="0 0 {self._width:.0f} {height:.0f}">',
            f"<title>{escape(self._title)}</title><style>{_STYLE}</style>",
            '<rect width="100%" height="100%" style="fill:#fff;stroke:none"/>',
            f"<defs>{_head('ahead', _FORWARD)}{_head('back', _FEEDBACK)}</defs>",
            *paths,
            *(_box(block) for block in self._blocks.values()),
            "</svg>",
        ]
        return "\n".join(parts) + "\n"

    def _path(self, index: int, lanes: Any) -> str:
        wire, chain = self._wires[index], self._chains[index]
        source, target = self._blocks[wire.source], self._blocks[wire.target]
        start = source.x + source.width, source.port_y(source.outputs, wire.output)
        end = target.x - 3.0, target.port_y(target.inputs, wire.input)
        if self._back[index]:
            lane = next(lanes)
            right = self._column[self._layer[wire.source]][1] + 16 + 6 * (lane % 5)
            left = self._column[self._layer[wire.target]][0] - 20 - 6 * (lane % 5)
            low = self._floor + _LANE * (lane + 1.5)
            way = f"H{right:.1f}V{low:.1f}H{left:.1f}V{end[1]:.1f}H{end[0]:.1f}"
            kind, head = "connection feedback", "back"
        else:
            points = [start]
            for layer, item in enumerate(chain[1:-1], self._layer[wire.source] + 1):
                y = self._top[item] + _DUMMY / 2.0
                points += [(self._column[layer][0], y), (self._column[layer][1], y)]
            way = _curve([*points, end])
            kind, head = "connection", "ahead"
        return (
            f'<path class="{kind}" d="M{start[0]:.1f} {start[1]:.1f}{way}" '
            f'marker-end="url(#{head})"><title>{escape(str(wire))}</title></path>'
        )


def _curve(points: Sequence[tuple[float, float]]) -> str:
    """Curves between columns, straight lines through them."""
    way = ""
    for k, ((x0, y0), (x1, y1)) in enumerate(itertools.pairwise(points)):
        if k % 2:
            way += f"H{x1:.1f}"
        else:
            bend = 0.5 * (x1 - x0)
            way += (
                f"C{x0 + bend:.1f} {y0:.1f} {x1 - bend:.1f} {y1:.1f} {x1:.1f} {y1:.1f}"
            )
    return way


def _head(name: str, colour: str) -> str:
    return (
        f'<marker id="{name}" viewBox="0 0 8 8" refX="6" refY="4" markerWidth="7" '
        f'markerHeight="7" orient="auto"><path d="M0 0L8 4L0 8z" fill="{colour}"/>'
        "</marker>"
    )


def _box(block: _Block) -> str:
    text = [
        f'<text class="name" x="{block.x + block.width / 2:.1f}" '
        f'y="{block.y + 19:.1f}">{escape(block.name)}</text>'
    ]
    for ports, kind, x in (
        (block.inputs, "input", block.x + 8.0),
        (block.outputs, "output", block.x + block.width - 8.0),
    ):
        text += [
            f'<text class="{kind}" x="{x:.1f}" '
            f'y="{block.port_y(ports, port) + 4:.1f}">{escape(port)}</text>'
            for port in ports
        ]
    return (
        f'<g class="system"><rect x="{block.x:.1f}" y="{block.y:.1f}" '
        f'width="{block.width:.1f}" height="{block.height:.1f}" rx="8"/>'
        f"{''.join(text)}</g>"
    )
