"""Strict YAML: what is read, and what is written so that it comes back.

Plain `yaml.safe_load` expands alias bombs, keeps the last of duplicate keys,
reads ``1e-3`` as a string and ``no`` as false, and dies of deep nesting. What is
read here is a tree of mappings with text keys, lists, text, true/false, null and
finite numbers; everything else is refused with its line.
"""

import math
import re
from pathlib import Path
from typing import Any

import yaml

from bath_drake.errors import BathDrakeError, shown
from bath_drake.files import read_bytes

MAX_YAML_BYTES = 256 * 1024
MAX_DEPTH = 16
# Longer integers are nobody's seed.
MAX_DIGITS = 64

_Error = type[BathDrakeError]
_TAG = "tag:yaml.org,2002:"
_SCALARS = (
    ("bool", r"true|false", "tf"),
    ("null", r"null|~|", ["n", "~", ""]),
    ("int", r"[-+]?[0-9]+", "-+0123456789"),
    (
        "float",
        r"[-+]?(?:[0-9]+\.[0-9]*|\.[0-9]+|[0-9]+(?=[eE]))(?:[eE][-+]?[0-9]+)?"
        r"|[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)",
        "-+0123456789.",
    ),
)


def _refusal(message: str, mark: Any) -> yaml.MarkedYAMLError:
    return yaml.MarkedYAMLError(problem=message, problem_mark=mark)


class _Loader(yaml.SafeLoader):
    """PyYAML's safe loader without aliases, tags, duplicates and deep nesting."""

    # Its own table: none of YAML 1.1's dates, sexagesimals, octals and yes/no.
    yaml_implicit_resolvers: dict[str, Any] = {}  # noqa: RUF012 (PyYAML's type)
    _depth = 0

    def compose_node(self, parent: Any, index: Any) -> Any:
        event: Any = self.peek_event()  # type: ignore[no-untyped-call]
        if isinstance(event, yaml.AliasEvent):
            raise _refusal("aliases (*name) are not allowed", event.start_mark)
        if event.anchor is not None:
            raise _refusal("anchors (&name) are not allowed", event.start_mark)
        if event.tag is not None:
            raise _refusal(
                f"tags ({shown(event.tag)}) are not allowed", event.start_mark
            )
        if self._depth >= MAX_DEPTH:
            raise _refusal(f"nested deeper than {MAX_DEPTH} levels", event.start_mark)
        self._depth += 1
        try:
            return super().compose_node(parent, index)
        finally:
            self._depth -= 1

    def construct_mapping(self, node: Any, deep: bool = False) -> dict[Any, Any]:
        mapping: dict[Any, Any] = {}
        for key_node, value_node in node.value:
            key = self.construct_object(key_node, deep=True)
            if not isinstance(key, str):
                raise _refusal(
                    f"key {shown(repr(key))} is not text", key_node.start_mark
                )
            if key in mapping:
                raise _refusal(f"duplicate key {shown(repr(key))}", key_node.start_mark)
            mapping[key] = self.construct_object(value_node, deep=True)
        return mapping

    def construct_finite(self, node: Any) -> float:
        value = str(node.value).lower()
        number = math.inf if value[-1] in "nf" else float(value)
        if not math.isfinite(number):
            raise _refusal(f"number {shown(value)} is not finite", node.start_mark)
        return number

    def construct_short_int(self, node: Any) -> int:
        if len(node.value) > MAX_DIGITS:
            raise _refusal(f"more than {MAX_DIGITS} digits", node.start_mark)
        return int(node.value)


class _Dumper(yaml.SafeDumper):
    """Writes what `_Loader` and any other YAML reader read back: no anchors."""

    def ignore_aliases(self, data: Any) -> bool:
        return True


for _name, _pattern, _first in _SCALARS:
    # The writer keeps YAML 1.1's table too, and so quotes what either would turn.
    for _class in (_Loader, _Dumper):
        _class.add_implicit_resolver(
            _TAG + _name, re.compile(f"^(?:{_pattern})$"), list(_first)
        )
_Loader.add_constructor(_TAG + "float", _Loader.construct_finite)
_Loader.add_constructor(_TAG + "int", _Loader.construct_short_int)


def parse_yaml(
    text: str | bytes, *, source: str = "YAML", error: _Error = BathDrakeError
) -> dict[str, Any]:
    """Reads one YAML mapping out of a text.

    Args:
        text: The text, UTF-8 when bytes, at most `MAX_YAML_BYTES` long.
        source: What to call it in messages, the file's path for instance.
        error: The exception to raise.

    Raises:
        BathDrakeError: As `error`, with source and line, when the text is no YAML
            or holds what this module refuses.
    """
    if len(text) > MAX_YAML_BYTES:
        raise error(
            f"{source}: {len(text)} bytes of YAML, at most {MAX_YAML_BYTES} are allowed"
        )
    if isinstance(text, bytes):
        try:
            text = text.decode("utf-8-sig")
        except UnicodeDecodeError as problem:
            raise error(f"{source}: not UTF-8 text (byte {problem.start})") from None
    loader: _Loader | None = None
    try:
        loader = _Loader(text)
        data = loader.get_single_data()
    except yaml.MarkedYAMLError as problem:
        mark = problem.problem_mark or problem.context_mark
        place = f"{source}: line {mark.line + 1}" if mark else source
        what = problem.problem or problem.context or "not YAML"
        raise error(f"{place}: {what}") from None
    except yaml.YAMLError as problem:
        raise error(f"{source}: not YAML: {str(problem).splitlines()[0]}") from None
    finally:
        if loader is not None:
            loader.dispose()
    if not isinstance(data, dict):
        found = "nothing" if data is None else type(data).__name__
        raise error(f"{source}: found {found}, expected a mapping of keys to values")
    return data


def read_yaml(path: str | Path, *, error: _Error = BathDrakeError) -> dict[str, Any]:
    """Reads a file as `parse_yaml` does; raises `error` on any bad file."""
    data = read_bytes(path, limit=MAX_YAML_BYTES, error=error)
    return parse_yaml(data, source=str(path), error=error)


def dump_yaml(data: dict[str, Any]) -> str:
    """Writes a tree of plain Python values as YAML.

    What `parse_yaml` reads back is equal, floats to the last bit.

    Raises:
        ValueError: On numbers that are not finite and values that are not plain
            (numpy arrays are to be turned into lists first) or nested too deep.
    """
    try:
        text: str = yaml.dump(
            data, Dumper=_Dumper, sort_keys=False, default_flow_style=None, width=88
        )
        kept = parse_yaml(text)
    except (yaml.YAMLError, BathDrakeError, RecursionError) as problem:
        raise ValueError(f"cannot be written as YAML: {problem}") from problem
    if kept != data:
        raise ValueError("holds values that YAML does not keep (tuples?)")
    return text
