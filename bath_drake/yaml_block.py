"""One mapping of a YAML file, whose values are taken key by key."""

from typing import Any, NoReturn, TypeVar

from bath_drake.errors import BathDrakeError, shown

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

    def is_text(self, key: str) -> bool:
        """Whether text stands under a key, which is left there."""
        return self.has(key) and isinstance(self._rest[key], str)

    def take_short(self, key: str, name: str) -> "Block":
        """Returns the text under a key as a mapping that has it under `name`."""
        return self._inner({name: self.take(key, str)}, key)

    def _checked(self, key: str, value: Any, kind: type[T]) -> T:
        if kind is float and type(value) is int:
            value = float(value)
        if type(value) is not kind:
            self.fail(key, f"found {shown(repr(value))}, expected {_KINDS[kind]}")
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

    def take_matrices(self, key: str) -> list[list[list[float]]]:
        """Returns the matrices of numbers, of any size, of the list under a key."""
        lists = self.take_list(key, list)
        named = {f"{key}[{i}]": rows for i, rows in enumerate(lists)}
        block = Block(named, self._source, self._key, self._error)
        return [block.take_rows(name, None, None) for name in named]

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
            self.fail(shown(key), f"unknown key, allowed: {allowed}")
