import math
import os
from pathlib import Path

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from bath_drake.errors import BathDrakeError, ScenarioError
from bath_drake.files import check_output, read_bytes, write_atomically
from bath_drake.yaml_block import Block
from bath_drake.yaml_io import (
    MAX_DEPTH,
    MAX_YAML_BYTES,
    dump_yaml,
    parse_yaml,
    read_yaml,
)

# Text that YAML can hold: no surrogates, no control characters but tab and newline.
TEXT = st.text(st.characters(codec="utf-8", exclude_categories=["Cc", "Cs"]))
SCALARS = (
    st.none()
    | st.booleans()
    | st.integers(-(10**30), 10**30)
    | st.floats(allow_nan=False, allow_infinity=False)
    | TEXT
    | st.sampled_from(["1e-3", "yes", "null", "~", "010", "1:30", "2026-01-01", "<<"])
)
TREES = st.dictionaries(
    TEXT,
    st.recursive(
        SCALARS,
        lambda inner: (
            st.lists(inner, max_size=4) | st.dictionaries(TEXT, inner, max_size=4)
        ),
        max_leaves=12,
    ),
    max_size=5,
)


# Written text is scanned in pure Python: the odd example takes longer than 200 ms.
@settings(deadline=None, max_examples=60)
@given(TREES)
def test_what_is_written_is_read_back_equal_to_the_last_bit(tree):
    back = parse_yaml(dump_yaml(tree))
    assert repr(back) == repr(tree)


@settings(deadline=None, max_examples=60)
@given(TREES)
def test_other_yaml_readers_read_what_is_written_too(tree):
    assert yaml.safe_load(dump_yaml(tree)) == tree


@settings(deadline=None, max_examples=100)
@given(st.text(max_size=200) | st.binary(max_size=200))
def test_any_text_is_read_or_refused_on_one_line(text):
    message = ""
    try:
        parse_yaml(text)
    except BathDrakeError as error:
        message = str(error)
    assert "\n" not in message


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1e-3", 1e-3),
        ("-9.3e-05", -9.3e-05),
        ("2E+4", 2e4),
        (".5", 0.5),
        ("5.", 5.0),
        ("010", 10),
        ("yes", "yes"),
        ("1:30", "1:30"),
        ("2026-01-01", "2026-01-01"),
        ("1_000", "1_000"),
        ("true", True),
        ("~", None),
    ],
)
def test_a_plain_scalar_means_what_it_looks_like(text, value):
    found = parse_yaml(f"a: {text}")["a"]
    assert found == value
    assert type(found) is type(value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "found nothing"),
        ("- 1", "found list"),
        ("a: 1\nb: 2\na: 3", r"line 3: duplicate key 'a'"),
        ("a: {b: 1, b: 1}", r"line 1: duplicate key 'b'"),
        ("a: &x 1", "anchors"),
        ("a: [1]\nb: *x", "line 2: aliases"),
        ("a: !!python/name:os.system ''", "tags"),
        ("a: !!str 1", "tags"),
        ("1: 2", "key 1 is not text"),
        ("? [a]\n: 2", "is not text"),
        ("? [" + "7, " * 999 + "7]\n: 2", r"key \[7, .{,60}\.\.\. is not text"),
        ("a: .nan", "not finite"),
        ("a: -.inf", "not finite"),
        ("a: 1e999", "not finite"),
        ("a: " + "9" * 5000, "digits"),
        ("a: [", "line 1"),
        ("a: 1\n---\nb: 2", "another document"),
        ("a: \0", "not allowed"),
        (b"a: \xff", "not UTF-8"),
        ("[" * 5000, "nested deeper"),
        ("{a: " * 5000, "nested deeper"),
        ("\n".join(" " * i + "a:" for i in range(500)), "nested deeper"),
        ("#" * (MAX_YAML_BYTES + 1), "bytes of YAML"),
    ],
)
def test_what_is_not_plain_yaml_is_refused(text, message):
    with pytest.raises(ScenarioError, match=message) as caught:
        parse_yaml(text, source="some.yaml", error=ScenarioError)
    assert str(caught.value).startswith("some.yaml")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "value", [math.nan, -math.inf, (1, 2), np.float64(1.0), np.zeros(2), {1: 2}, {1}]
)
def test_what_yaml_does_not_keep_is_not_written(value):
    with pytest.raises(ValueError, match=r"cannot be written|does not keep"):
        dump_yaml({"a": value})


def test_a_tree_too_deep_to_read_is_not_written():
    tree: dict[str, object] = {}
    for _ in range(MAX_DEPTH + 1):
        tree = {"a": tree}
    with pytest.raises(ValueError, match="nested deeper"):
        dump_yaml(tree)


def block(text):
    return Block(parse_yaml(text), "some.yaml", error=ScenarioError)


def test_a_block_gives_values_of_the_kind_asked_for():
    b = block(
        "n: 3\nx: 1e-3\nv: [1, 2.5]\nm: [[1, 2], [3, 4]]\ns: {t: yes}\nl: [{a: 1}]\no:"
    )
    assert b.take("n", int) == 3
    assert b.take("x", float) == 1e-3
    assert b.take_list("v", float, 2) == [1.0, 2.5]
    assert b.take_rows("m", 2, 2) == [[1.0, 2.0], [3.0, 4.0]]
    assert b.take_block("s").take("t", str) == "yes"
    assert [inner.take("a", int) for inner in b.take_blocks("l")] == [1]
    assert not b.has("other")
    assert [b.take_null(key) for key in ("other", "o")] == [False, True]
    b.finish()


@pytest.mark.parametrize(
    ("take", "message"),
    [
        (lambda b: b.take("absent", float), "s.absent: is missing, expected a number"),
        (lambda b: b.take("flag", float), "s.flag: found True, expected a number"),
        (lambda b: b.take("flag", int), "s.flag: found True, expected an integer"),
        (lambda b: b.take("v", str), r"s.v: found \[1, 'x'\], expected text"),
        (lambda b: b.take_list("v", float), r"s.v\[1\]: found 'x', expected a number"),
        (lambda b: b.take_list("v", float, 3), "s.v: found 2 items, expected 3"),
        (lambda b: b.take_rows("m", 2, 2), r"s.m\[1\]: found 1 items, expected 2"),
        (lambda b: b.take_block("v"), "s.v: .*expected a mapping"),
        (lambda b: b.take_blocks("l")[0].take("b", str), r"s.l\[0\].b: is missing"),
        (lambda b: b.finish(), "s.flag: unknown key, allowed: known"),
    ],
)
def test_a_wrong_value_is_refused_by_its_dotted_key(take, message):
    b = block("s: {flag: true, v: [1, x], m: [[1, 2], [3]], l: [{a: 1}]}").take_block(
        "s"
    )
    b.has("known")
    with pytest.raises(ScenarioError, match=f"^some.yaml: {message}"):
        take(b)


def test_reading_refuses_what_is_no_regular_file_of_bounded_size(tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    big = tmp_path / "big"
    big.write_bytes(b"x" * 11)
    for path, message in [
        (tmp_path / "absent", "cannot be read: No such file"),
        (tmp_path, "found a directory"),
        (pipe, "found not a file"),
        (big, "11 bytes, at most 10"),
        ("a\0b", "not a file name"),
    ]:
        with pytest.raises(ScenarioError, match=message):
            read_bytes(path, limit=10, error=ScenarioError)
    big.write_bytes(b"x" * 10)
    assert read_bytes(big, limit=10, error=ScenarioError) == b"x" * 10


def test_a_file_is_replaced_whole_and_readable_by_others(tmp_path):
    path = tmp_path / "a.yaml"
    plain = tmp_path / "plain"
    plain.write_text("")
    for content in ("a: 1", b"a: 2", lambda p: p.write_text("a: 3")):
        write_atomically(path, content)
    assert read_yaml(path) == {"a": 3}
    assert path.stat().st_mode == plain.stat().st_mode
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.yaml", "plain"]


def test_a_failed_write_leaves_what_was_there(tmp_path):
    path = tmp_path / "a.yaml"
    path.write_text("old")

    def fail(temporary: Path) -> None:
        temporary.write_text("half")
        raise OSError(28, "No space left on device")

    with pytest.raises(ScenarioError, match="No space left"):
        write_atomically(path, fail, error=ScenarioError)
    assert [p.read_text() for p in tmp_path.iterdir()] == ["old"]


def test_an_output_path_is_checked_before_anything_is_written(tmp_path):
    check_output(tmp_path / "new.yaml")
    for path, message in [
        (tmp_path, "not the name of a file"),
        (tmp_path / "absent" / "a.yaml", "does not exist"),
        ("a\0b", "not the name of a file"),
    ]:
        with pytest.raises(BathDrakeError, match=message):
            check_output(path)
    assert list(tmp_path.iterdir()) == []
