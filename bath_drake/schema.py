"""Fills dataclass schemas from YAML blocks, naming the dotted key of each mistake.

Drake's `yaml_load_typed` does the same job but its messages name no key.
"""

from dataclasses import fields, is_dataclass
from types import NoneType, UnionType
from typing import Any, Protocol, TypeVar, get_args, get_origin, get_type_hints

from bath_drake.yaml_block import Block

T = TypeVar("T")


class Completed(Protocol):
    """A schema whose defaults depend on what is given."""

    @staticmethod
    def complete(given: dict[str, Any]) -> dict[str, Any]:
        """Returns the values for what is given and what follows from it.

        Raises:
            ValueError: "key: found ..., allowed ..." if nothing follows.
        """
        ...


def fill(schema: type[T], block: Block) -> T:
    """Returns an instance of `schema` with the block's values in place of defaults.

    Fields may be bool, int, float, str, lists of those, lists of lists of floats or of
    such lists, other such dataclasses, lists of them, and any of these or None
    (`X | None`). A schema
    with a method `complete` (see `Completed`) says itself what follows from the values
    given. One with a text `SHORTHAND`, the name of a field, may be written as that
    field's value alone.

    Args:
        schema: A dataclass whose every field has a default.
        block: The mapping; its error is raised on unknown keys and wrong kinds.

    Raises:
        TypeError: If the schema has a field of another kind.
    """
    kinds = get_type_hints(schema)
    values: dict[str, Any] = {}
    for field in fields(schema):  # type: ignore[arg-type]  # a dataclass by contract
        if block.has(field.name):
            values[field.name] = _take(block, field.name, kinds[field.name])
    block.finish()
    complete = getattr(schema, "complete", None)
    if complete is not None:
        try:
            values = complete(values)
        except ValueError as error:
            key, _, message = str(error).partition(": ")
            block.fail(key, message)
    return schema(**values)


def _take(block: Block, key: str, kind: Any) -> Any:
    if isinstance(kind, UnionType):
        alternatives = get_args(kind)
        if len(alternatives) != 2 or NoneType not in alternatives:
            raise TypeError(f"a schema cannot hold {kind}")
        if block.take_null(key):
            return None
        (kind,) = (k for k in alternatives if k is not NoneType)
    if is_dataclass(kind):
        shorthand = getattr(kind, "SHORTHAND", None)
        if shorthand is not None and block.is_text(key):
            return fill(kind, block.take_short(key, shorthand))  # type: ignore[arg-type]
        return fill(kind, block.take_block(key))  # type: ignore[arg-type]
    if kind == list[list[list[float]]]:
        return block.take_matrices(key)
    if get_origin(kind) is list and get_origin(get_args(kind)[0]) is list:
        return block.take_rows(key, None, None)
    if get_origin(kind) is list and is_dataclass(get_args(kind)[0]):
        return [fill(get_args(kind)[0], inner) for inner in block.take_blocks(key)]
    if get_origin(kind) is list:
        return block.take_list(key, get_args(kind)[0])
    if kind in (bool, int, float, str):
        return block.take(key, kind)
    raise TypeError(f"a schema cannot hold {kind}")
