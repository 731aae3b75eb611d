"""How much of each MakeHuman target a person is made of.

A phenotype is a number between anchors, MakeHuman's pure types; a target belongs to
one combination of types and counts by the product of their shares.
"""

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

AGES = ("child", "young", "old")
GENDERS = ("male", "female")
MUSCLES = ("minmuscle", "averagemuscle", "maxmuscle")
WEIGHTS = ("minweight", "averageweight", "maxweight")
HEIGHTS = ("minheight", "maxheight")
PROPORTIONS = ("idealproportions", "uncommonproportions")
RACES = ("african", "asian", "caucasian")
CUPS = ("mincup", "averagecup", "maxcup")
FIRMNESSES = ("minfirmness", "averagefirmness", "maxfirmness")

_HALVES = (0.0, 0.5, 1.0)
_ENDS = (0.0, 1.0)
_AGES_AT = (1.0 / 3.0, 2.0 / 3.0, 1.0)


@dataclass(frozen=True, kw_only=True)
class Phenotype:
    """Who a person is, in MakeHuman's terms.

    Attributes:
        gender: 0 male to 1 female.
        age: 2/3 young (25 years) to 1 old (90 years).
        muscle: 0 to 1, 0.5 average.
        weight: 0 to 1, 0.5 average; up to 2 carries on beyond MakeHuman's maximum.
        height: 0 to 1.
        proportions: 0 ideal to 1 uncommon.

    MakeHuman's three origins count a third each: the shape says nothing of skin.
    """

    gender: float
    age: float
    muscle: float
    weight: float
    height: float
    proportions: float


def shares(value: float, types: tuple[str, ...], at: tuple[float, ...]) -> dict:
    """Returns each type's share of a value: linear between the nearest two types.

    Beyond the last type the line goes on, so that shares may be negative.

    Args:
        value: The phenotype's number.
        types: MakeHuman's names.
        at: Their numbers, ascending.
    """
    above = min(max(sum(value >= anchor for anchor in at), 1), len(at) - 1)
    part = (value - at[above - 1]) / (at[above] - at[above - 1])
    found = dict.fromkeys(types, 0.0)
    found[types[above - 1]], found[types[above]] = 1.0 - part, part
    return found


def targets(who: Phenotype) -> Iterator[tuple[Path, float]]:
    """Yields the files under `targets` that shape a person, and how much of each.

    Some combinations have no file: MakeHuman needs no target for its base.
    """
    share = (
        shares(who.gender, GENDERS, _ENDS)
        | shares(who.age, AGES, _AGES_AT)
        | shares(who.muscle, MUSCLES, _HALVES)
        | shares(who.weight, WEIGHTS, _HALVES)
        | shares(who.height, HEIGHTS, _ENDS)
        | shares(who.proportions, PROPORTIONS, _ENDS)
        | shares(0.5, CUPS, _HALVES)
        | shares(0.5, FIRMNESSES, _HALVES)
        | dict.fromkeys(RACES, 1.0 / 3.0)
    )
    macro = Path("macrodetails")
    body = (GENDERS, AGES, MUSCLES, WEIGHTS)
    families = (
        (macro, "universal-", body),
        (macro, "", (RACES, GENDERS, AGES)),
        (macro / "height", "", (*body, HEIGHTS)),
        (macro / "proportions", "", (*body, PROPORTIONS)),
        (Path("breast"), "", (("female",), *body[1:], CUPS, FIRMNESSES)),
    )
    for folder, prefix, kinds in families:
        for types in itertools.product(*kinds):
            amount = 1.0
            for name in types:
                amount *= share[name]
            if amount != 0.0:
                yield folder / f"{prefix}{'-'.join(types)}.target.gz", amount
