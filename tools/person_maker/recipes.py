"""The recipes of the shipped people: people.yaml, read strictly."""

import re
from dataclasses import dataclass, fields
from pathlib import Path

from bath_drake.errors import BathDrakeError
from bath_drake.yaml_block import Block
from bath_drake.yaml_io import read_yaml
from person_maker.phenotypes import Phenotype

# Adults only; a weight above 1 carries MakeHuman's heaviest on.
_RANGES = {"age": (2.0 / 3.0, 1.0), "weight": (0.0, 2.0)}
# A folder's name is also what is typed after --person.
_NAME = re.compile(r"[a-z][a-z0-9_]*")

Colour = tuple[int, int, int]


class RecipeError(BathDrakeError):
    """A recipe in people.yaml cannot be used."""


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """What makes a person.

    Attributes:
        name: In words.
        phenotype: The body's shape.
        skin: Its colour, red, green and blue, 0 to 255.
        hair: Likewise.
        trunks: Likewise.
    """

    name: str
    phenotype: Phenotype
    skin: Colour
    hair: Colour
    trunks: Colour


def read_recipes(path: Path) -> dict[str, Recipe]:
    """Returns the recipes by the people's folder names.

    Raises:
        RecipeError: If the file is missing or a value is not allowed; names the key.
    """
    people = read_yaml(path, error=RecipeError)
    file = Block(people, str(path), error=RecipeError)
    found = {}
    for folder in people:
        if not _NAME.fullmatch(str(folder)):
            file.fail(str(folder), "a folder's name is lower-case letters, digits, _")
        found[folder] = _recipe(file.take_block(folder))
    return found


def _recipe(block: Block) -> Recipe:
    name = block.take("name", str)
    shape = block.take_block("phenotype")
    values = {}
    for field in fields(Phenotype):
        low, high = _RANGES.get(field.name, (0.0, 1.0))
        value = shape.take(field.name, float)
        if not low <= value <= high:
            shape.fail(field.name, f"found {value}, allowed {low:.3g} to {high:.3g}")
        values[field.name] = value
    shape.finish()
    colours = [_colour(block, key) for key in ("skin", "hair", "trunks")]
    block.finish()
    skin, hair, trunks = colours
    return Recipe(
        name=name, phenotype=Phenotype(**values), skin=skin, hair=hair, trunks=trunks
    )


def _colour(block: Block, key: str) -> Colour:
    red, green, blue = block.take_list(key, int, 3)
    for value in (red, green, blue):
        if not 0 <= value <= 255:
            block.fail(key, f"found {value}, allowed 0 to 255")
    return red, green, blue
