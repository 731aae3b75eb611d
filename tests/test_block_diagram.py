import itertools
import re
from xml.etree import ElementTree

import pytest
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import Adder, ConstantVectorSource, Integrator

from bath_drake.cli import main
from bath_drake.diagrams.block_diagram import draw_block_diagram, wiring_lines
from bath_drake.diagrams.graph_layout import (
    Connection,
    assign_layers,
    forward_order,
    spread,
)

SVG = "{http://www.w3.org/2000/svg}"


@pytest.fixture(scope="module")
def loop():
    """A source and an integrator that feeds back into their sum."""
    builder = DiagramBuilder()
    source = builder.AddNamedSystem("source<1>", ConstantVectorSource([1.0]))
    adder = builder.AddNamedSystem("adder", Adder(2, 1))
    integrator = builder.AddNamedSystem("integrator", Integrator(1))
    second = builder.AddNamedSystem("second_integrator", Integrator(1))
    builder.AddNamedSystem("alone", ConstantVectorSource([2.0]))
    builder.Connect(source.get_output_port(), adder.get_input_port(0))
    builder.Connect(integrator.get_output_port(), adder.get_input_port(1))
    builder.Connect(adder.get_output_port(), integrator.get_input_port())
    builder.Connect(adder.get_output_port(), second.get_input_port())
    return builder.Build()


@pytest.fixture(scope="module")
def svg(loop):
    return ElementTree.fromstring(draw_block_diagram(loop))


def _boxes(svg):
    boxes = []
    for group in svg.iter(f"{SVG}g"):
        rect = group.find(f"{SVG}rect")
        boxes.append([float(rect.get(k)) for k in ("x", "y", "width", "height")])
    return boxes


def test_wiring_lines_are_sorted_and_complete(loop):
    assert wiring_lines(loop) == [
        "adder.sum -> integrator.u0",
        "adder.sum -> second_integrator.u0",
        "integrator.y0 -> adder.u1",
        "source<1>.y0 -> adder.u0",
    ]


def test_every_system_is_drawn_once(svg):
    names = [t.text for t in svg.iter(f"{SVG}text") if t.get("class") == "name"]
    assert sorted(names) == [
        "adder",
        "alone",
        "integrator",
        "second_integrator",
        "source<1>",
    ]


def test_every_connection_is_drawn_once(loop, svg):
    paths = [p for p in svg.iter(f"{SVG}path") if "connection" in p.get("class", "")]
    titles = sorted(p.find(f"{SVG}title").text for p in paths)
    assert titles == wiring_lines(loop)


def test_only_what_closes_a_cycle_is_feedback(svg):
    feedback = [p for p in svg.iter(f"{SVG}path") if "feedback" in p.get("class", "")]
    assert len(feedback) == 1


def test_boxes_neither_overlap_nor_leave_the_page(svg):
    boxes = _boxes(svg)
    width, height = float(svg.get("width")), float(svg.get("height"))
    for x, y, w, h in boxes:
        assert x >= 0
        assert y >= 0
        assert x + w <= width
        assert y + h <= height
    for (x, y, w, h), (p, q, r, s) in itertools.combinations(boxes, 2):
        assert x + w <= p or p + r <= x or y + h <= q or q + s <= y


def test_the_drawing_is_the_same_each_time(loop):
    assert draw_block_diagram(loop) == draw_block_diagram(loop)
    assert not re.search(r"\bnan\b", draw_block_diagram(loop))


def _wires(text):
    return [Connection(a, "y", b, "u") for a, b in text.split()]


@pytest.mark.parametrize(
    ("edges", "fewest"),
    [("ab bc cd ad", 0), ("ab bc ca", 1), ("ab bc ca cd de ec", 2), ("aa ab", 1)],
)
def test_no_more_connections_than_needed_point_back(edges, fewest):
    wires = _wires(edges)
    names = sorted({w.source for w in wires} | {w.target for w in wires})
    order = forward_order(names, wires)
    assert sorted(order) == names
    back = [w for w in wires if order.index(w.source) >= order.index(w.target)]
    assert len(back) == fewest


def test_layers_rise_along_forward_connections():
    wires = _wires("ab bc cd ad xd")
    order = forward_order("abcdx", wires)
    layer = assign_layers(order, wires)
    assert all(layer[w.source] < layer[w.target] for w in wires)
    assert layer["x"] == layer["d"] - 1  # a source sits by its user


def test_spread_keeps_places_that_do_not_overlap():
    assert spread([0.0, 50.0], [10.0, 10.0], 5.0) == [0.0, 50.0]


def test_spread_parts_overlapping_boxes_about_their_middle():
    tops = spread([20.0, 20.0, 20.0], [10.0, 10.0, 10.0], 5.0)
    assert tops == pytest.approx([5.0, 20.0, 35.0])


@pytest.mark.parametrize(
    "arguments", [["no_such_scenario"], ["reproduction", "-o", "no/such/folder.svg"]]
)
def test_the_command_fails_on_one_line(arguments, capsys):
    assert main(["diagram", *arguments]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "no" in error
