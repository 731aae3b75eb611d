"""Made-up skills, single and composed, and other versions of their files."""

from dataclasses import replace

import numpy as np

from bath_drake.composition.branch import Branch
from bath_drake.composition.chain import Chain, Gate
from bath_drake.composition.conditioning import Conditioning
from bath_drake.composition.rollout import chain_rollout
from bath_drake.demonstrations.canonical import CanonicalFrame
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.learning.skill import Skill
from bath_drake.learning.strokes import resample
from bath_drake.skill_file import skill_to_mapping

FRAME = CanonicalFrame(
    "path_plane",
    np.array([0.1, 0.2, 1 / 3]),
    np.array([[0.6, 0.8, 0.0], [0.0, 0.0, 1.0]]),
    np.array([0.2, 0.25]),
)


def single_branch(field, start, mean=None, **changes):
    mean = np.array([start, field.goal]) if mean is None else mean
    values = {"starts": np.array([start]), "mean": mean, "start": start}
    return Branch(Chain((field,)), **(values | changes))


def with_branch(skill, **changes):
    """The skill with its first branch changed, its certificates left as they are."""
    if "field" in changes:
        changes["chain"] = Chain((changes.pop("field"),))
    return replace(
        skill, branches=(replace(skill.branches[0], **changes), *skill.branches[1:])
    )


def old_mapping(skill, version=2):
    """A single skill as a file of an older version holds it, without a checksum."""
    data = skill_to_mapping(skill)
    (branch,) = data.pop("branches")
    del data["finished"]
    mean = branch["mean_demonstration"]
    return data | {"schema_version": version, "mean_demonstration": mean}


def stage(goal, rows, kappa=5.0):
    disc = Workspace(np.zeros(2), np.array([2.0, 2.0]))
    theta = np.array(rows, dtype=float).reshape(-1, 5)
    return NavigationField(disc, np.array(goal), kappa, ObstacleSet(theta))


def crossing_chain():
    """A loop that crosses itself: right, up and round, and down across the way."""
    return Chain(
        (
            stage([0.75, 0.05], [[0.0, -0.28, 0.2, 0.1, 0.3]]),
            stage([0.05, 0.72], [[0.25, 0.25, 0.15, 0.1, -0.8]]),
            stage([-0.1, -0.7], [[0.2, 0.05, 0.1, 0.16, 0.1]]),
        ),
        (
            Gate(np.array([0.6, 0.05]), np.array([1.0, 0.1]), 0.3),
            Gate(np.array([0.15, 0.62]), np.array([-1.0, 1.0]), 0.25),
        ),
    )


def composed_skill(chains=None, conditioned=False):
    """A skill of one branch or more, without certificates."""
    branches = []
    for chain in chains or (crossing_chain(),):
        start = np.array([-0.7, -0.1 - 0.2])
        path = chain_rollout(start, chain).path
        starts = start + np.array([[0.0, 0.02], [0.01, -0.02]])
        how = conditioning(chain, start, starts) if conditioned else None
        branches.append(Branch(chain, start, starts, resample(path, 80), how))
    return Skill(
        branches=tuple(branches),
        seed=3,
        config={"method": "auto"},
        demonstration_hashes=("ab" * 32, "cd" * 32),
        canonical=FRAME,
        scale=4 / 3,
        frechet={"to_mean": 0.1 / 3},
    )


def conditioning(chain, start, starts):
    """Small moves of every stage with the ends; any numbers do."""
    rng = np.random.default_rng(4)
    stages, columns = len(chain), 4 + len(starts)
    return Conditioning(
        start=start,
        goal=chain.goal,
        starts=starts,
        width=0.1,
        reach=0.3,
        pivots=rng.normal(size=(stages, 2)),
        coefficients=0.05 * rng.normal(size=(stages, 4, columns)),
    )
