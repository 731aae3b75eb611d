from dataclasses import dataclass, field

import pytest

from bath_drake.errors import ScenarioError
from bath_drake.schema import fill
from bath_drake.yaml_block import Block


@dataclass(kw_only=True)
class Inner:
    gain: float = 1.0
    names: list[str] = field(default_factory=list)


@dataclass(kw_only=True)
class Outer:
    on: bool = False
    count: int = 3
    speed: float = 0.5
    title: str = "none"
    corners: list[float] = field(default_factory=lambda: [0.0])
    rows: list[list[float]] = field(default_factory=list)
    polygons: list[list[list[float]]] = field(default_factory=list)
    limit: float | None = 2.0
    inner: Inner = field(default_factory=Inner)
    extra: Inner | None = None


def filled(**mapping):
    return fill(Outer, Block(mapping, "file.yaml", error=ScenarioError))


def test_nothing_leaves_every_default():
    assert filled() == Outer()


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("on", True),
        ("count", -7),
        ("speed", 1e-3),
        ("title", "true"),
        ("corners", []),
        ("corners", [1.5, -2.0]),
        ("rows", [[1.0, 2.0], [], [3.0]]),
        ("limit", 0.1),
        ("limit", None),
    ],
)
def test_a_value_of_its_kind_replaces_its_default_alone(key, value):
    expected = Outer()
    setattr(expected, key, value)
    assert filled(**{key: value}) == expected


@pytest.mark.parametrize("key", ["speed", "limit"])
def test_an_integer_serves_as_a_number(key):
    value = getattr(filled(**{key: 2}), key)
    assert value == 2.0
    assert isinstance(value, float)


def test_integers_serve_as_numbers_in_a_list():
    corners = filled(corners=[1, 2.5]).corners
    assert corners == [1.0, 2.5]
    assert all(isinstance(corner, float) for corner in corners)


def test_blocks_are_filled_with_their_own_defaults():
    outer = filled(inner={"gain": 2}, extra={"names": ["a", "b"]})
    assert outer == Outer(inner=Inner(gain=2.0), extra=Inner(names=["a", "b"]))
    assert filled(extra=None).extra is None
    assert filled(extra={}).extra == Inner()


def test_two_fillings_share_nothing():
    first, second = filled(), filled()
    first.corners.append(9.0)
    first.inner.names.append("x")
    assert second == Outer()


@pytest.mark.parametrize(
    ("mapping", "message"),
    [
        ({"speeed": 1.0}, "file.yaml: speeed: unknown key, allowed: on, count, speed"),
        ({"inner": {"gian": 1}}, "inner.gian: unknown key, allowed: gain, names"),
        ({"extra": {"gian": 1}}, "extra.gian: unknown key"),
        ({"on": 1}, "on: found 1, expected true or false"),
        ({"on": "yes"}, "on: found 'yes'"),
        ({"count": 3.0}, "count: found 3.0, expected an integer"),
        ({"count": True}, "count: found True, expected an integer"),
        ({"speed": True}, "speed: found True, expected a number"),
        ({"speed": "1"}, "speed: found '1', expected a number"),
        ({"title": 3}, "title: found 3, expected text"),
        ({"corners": 1.0}, "corners: found 1.0, expected a list"),
        ({"corners": [0.0, "b"]}, r"corners\[1\]: found 'b', expected a number"),
        ({"inner": [1]}, r"inner: found \[1\], expected a mapping"),
        ({"inner": {"gain": "x"}}, "inner.gain: found 'x', expected a number"),
        ({"inner": {"names": [1]}}, r"inner.names\[0\]: found 1, expected text"),
        ({"extra": {"gain": []}}, r"extra.gain: found \[\]"),
        ({"limit": "none"}, "limit: found 'none', expected a number"),
        # Null stands only where None is a choice.
        ({"speed": None}, "speed: found None"),
        ({"inner": None}, "inner: found None"),
        ({"corners": None}, "corners: found None"),
    ],
)
def test_a_mistake_is_named_by_file_and_dotted_key(mapping, message):
    with pytest.raises(ScenarioError, match=message):
        filled(**mapping)


@pytest.mark.parametrize("kind", [dict[str, int], int | str, int | str | None, object])
def test_a_schema_of_another_kind_is_the_programmers_mistake(kind):
    schema = dataclass(type("Odd", (), {"__annotations__": {"odd": kind}, "odd": None}))
    with pytest.raises(TypeError, match="a schema cannot hold"):
        fill(schema, Block({"odd": 1}, "file.yaml"))


def test_lists_of_matrices_are_taken_and_their_mistakes_named():
    polygons = [[[0, 1.5], [2.0, 3.0]], [[1.0]]]
    assert filled(polygons=polygons).polygons == polygons
    with pytest.raises(ScenarioError, match=r"polygons\[1\]\[0\]\[1\]: found 'x'"):
        filled(polygons=[[[0.0]], [[1.0, "x"]]])
    with pytest.raises(ScenarioError, match=r"polygons\[0\]\[1\]: found 3.0"):
        filled(polygons=[[[0.0], 3.0]])
