"""Strict YAML, and files that are read within limits and written whole.

Plain `yaml.safe_load` expands alias bombs, keeps the last of duplicate keys,
reads ``1e-3`` as a string and ``no`` as false, and dies of deep nesting. What is
read here is a tree of mappings with text keys, lists, text, true/false, null and
finite numbers; everything else is refused with its line.
"""

import math
import os
import re
import stat
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn, TypeVar

import yaml

from bath_drake.errors import BathDrakeError

MAX_YAML_BYTES = 256 * 1024
MAX_DEPTH = 16
# Longer integers are nobody's seed.
MAX_DIGITS = 64

T = TypeVar("T")
_Error = type[BathDrakeError]
_KINDS: dict[type, str] = {
    float: "a number",
    int: "an integer",
    str: "text",
    bool: "true or false",
    list: "a list",
    dict: "a mapping",
}
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
            raise _refusal(f"tags ({event.tag}) are not allowed", event.start_mark)
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
                raise _refusal(f"key {key!r} is not text", key_node.start_mark)
            if key in mapping:
                raise _refusal(f"duplicate key {key!r}", key_node.start_mark)
            mapping[key] = self.construct_object(value_node, deep=True)
        return mapping

    def construct_finite(self, node: Any) -> float:
        value = str(node.value).lower()
        number = math.inf if value[-1] in "nf" else float(value)
        if not math.isfinite(number):
            raise _refusal(f"number {value} is not finite", node.start_mark)
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


class Block:
    """One mapping of a YAML file, whose values are taken key by key.

    Each take checks the kind and names the dotted key when it is wrong; `finish`
    refuses the keys nobody took.
    """

    def __init__(
        self,
        mapping: dict[str, Any],
        source: str,
        key: str = "",
        error: _Error = BathDrakeError,
    ) -> None:
        """Wraps a mapping; `key` is its dotted name, empty for the file."""
        self._rest = dict(mapping)
        self._known: list[str] = []
        self._source = source
        self._key = key
        self._error = error

    def fail(self, key: str, message: str) -> NoReturn:
        """Raises the error of this file about one key."""
        dotted = ".".join(part for part in (self._key, key) if part)
        raise self._error(f"{self._source}: {dotted or 'file'}: {message}")

    def has(self, key: str) -> bool:
        """Whether a key is there and not yet taken; makes the key a known one."""
        self._known.append(key)
        return key in self._rest

    def take(self, key: str, kind: type[T]) -> T:
        """Returns the value of a key; int serves as float, true/false never do."""
        if not self.has(key):
            self.fail(key, f"is missing, expected {_KINDS[kind]}")
        return self._checked(key, self._rest.pop(key), kind)

    def take_null(self, key: str) -> bool:
        """Whether the key's value is null; takes it if so."""
        if not self.has(key) or self._rest[key] is not None:
            return False
        del self._rest[key]
        return True

    def is_list(self, key: str) -> bool:
        """Whether a list stands under a key, which is left there."""
        return self.has(key) and isinstance(self._rest[key], list)

    def _checked(self, key: str, value: Any, kind: type[T]) -> T:
        if kind is float and type(value) is int:
            value = float(value)
        if type(value) is not kind:
            self.fail(key, f"found {_shown(repr(value))}, expected {_KINDS[kind]}")
        return value

    def take_list(self, key: str, kind: type[T], length: int | None = None) -> list[T]:
        """Returns a list whose items are all of one kind, of one length if given."""
        items = self.take(key, list)
        if length is not None and len(items) != length:
            self.fail(key, f"found {len(items)} items, expected {length}")
        return [self._checked(f"{key}[{i}]", v, kind) for i, v in enumerate(items)]

    def take_rows(
        self, key: str, rows: int | None, columns: int | None
    ) -> list[list[float]]:
        """Returns a matrix of numbers, row by row; None takes any number of them."""
        lists = self.take_list(key, list, rows)
        named = {f"{key}[{i}]": row for i, row in enumerate(lists)}
        block = Block(named, self._source, self._key, self._error)
        return [block.take_list(name, float, columns) for name in named]

    def take_block(self, key: str) -> "Block":
        """Returns the mapping under a key."""
        return self._inner(self.take(key, dict), key)

    def take_blocks(self, key: str) -> list["Block"]:
        """Returns the mappings of the list under a key."""
        mappings = self.take_list(key, dict)
        return [self._inner(m, f"{key}[{i}]") for i, m in enumerate(mappings)]

    def _inner(self, mapping: dict[str, Any], key: str) -> "Block":
        dotted = f"{self._key}.{key}".strip(".")
        return Block(mapping, self._source, dotted, self._error)

    def finish(self) -> None:
        """Refuses keys that nobody asked for."""
        for key in self._rest:
            allowed = ", ".join(dict.fromkeys(self._known))
            self.fail(_shown(key), f"unknown key, allowed: {allowed}")


def _shown(text: str) -> str:
    """A text as a short piece of one line."""
    text = " ".join(text.split())
    return text if len(text) <= 60 else text[:57] + "..."


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


def read_bytes(path: str | Path, *, limit: int, error: _Error) -> bytes:
    """Returns a regular file's bytes; raises `error` if there is none or too many."""
    try:
        status = os.stat(path)
        # A pipe or a device would block or never end.
        if not stat.S_ISREG(status.st_mode):
            kind = "a directory" if stat.S_ISDIR(status.st_mode) else "not a file"
            raise error(f"{path}: found {kind}, expected a regular file")
        if status.st_size > limit:
            raise error(
                f"{path}: {status.st_size} bytes, at most {limit} bytes are allowed"
            )
        with open(path, "rb") as file:
            return file.read(limit + 1)[:limit]
    except OSError as problem:
        raise error(f"{path}: cannot be read: {problem.strerror}") from None
    except BathDrakeError:
        raise
    except ValueError as problem:
        raise error(f"{str(path)!r} is not a file name: {problem}") from None


def check_output(path: str | Path, *, error: _Error = BathDrakeError) -> None:
    """Raises `error` unless a file can be written at a path; touches nothing."""
    path = Path(path)
    if "\0" in str(path) or path.is_dir():
        raise error(f"{str(path)!r} is not the name of a file to write")
    if not path.parent.is_dir():
        raise error(f"{path}: folder {path.parent} does not exist")
    if not os.access(path.parent, os.W_OK | os.X_OK):
        raise error(f"{path}: folder {path.parent} cannot be written to")


def write_atomically(
    path: str | Path,
    content: str | bytes | Callable[[Path], None],
    *,
    error: _Error = BathDrakeError,
) -> None:
    """Writes a file whole or not at all: a temporary neighbour, then one rename.

    Args:
        path: Where; an existing file is replaced.
        content: Text (written as UTF-8), bytes, or a function that writes the
            temporary file whose path (same suffix) it is given.
        error: The exception to raise.

    Raises:
        BathDrakeError: As `error`, when the file cannot be written.
    """
    check_output(path, error=error)
    path, temporary = Path(path), ""
    try:
        handle, temporary = tempfile.mkstemp(
            prefix=f".{path.stem[:100]}-", suffix=path.suffix, dir=path.parent
        )
        os.close(handle)
        if callable(content):
            content(Path(temporary))
        else:
            data = content.encode() if isinstance(content, str) else content
            Path(temporary).write_bytes(data)
        # Renamed before its content is on disk, it could be empty after a power cut.
        with open(temporary, "rb") as file:
            os.fsync(file.fileno())
        # mkstemp makes files for the owner alone; give what `open` would have.
        os.umask(mask := os.umask(0))
        os.chmod(temporary, 0o666 & ~mask)
        os.replace(temporary, path)
    except OSError as problem:
        raise error(f"{path}: cannot be written: {problem.strerror}") from None
    finally:
        if temporary:  # after the rename there is nothing left of it
            Path(temporary).unlink(missing_ok=True)
