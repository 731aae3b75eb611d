"""Fields, and chains of them, as the `field` block of a YAML file.

Floats come back to the last bit. A block may stand in any YAML file::

    field:
      workspace: {centre: [0, 0], semi_axes: [5, 5], power: 2}
      goal: [3, 0]
      kappa: 4
      obstacles:
        - {centre: [0, 0], semi_axes: [1, 1], angle: 0, exponent: 1}

It may also be a list of such mappings, followed in turn. All but the last then have a
`gate`, at which the next takes over; where the list holds several chains, `branch`
numbers them from 0, the fields of each one together::

    field:
      - workspace: ...
        gate: {centre: [1, 0], direction: [1, 0], radius: 0.1}
      - workspace: ...
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from bath_drake.composition.chain import Chain, Gate
from bath_drake.errors import SkillFileError
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.yaml_block import Block

GATE = "gate"
BRANCH = "branch"


def field_to_mapping(field: NavigationField) -> dict[str, Any]:
    """A field as the tree of plain values of its `field` block."""
    workspace, obstacles = field.workspace, field.obstacles
    return {
        "workspace": {
            "centre": workspace.centre.tolist(),
            "semi_axes": workspace.semi_axes.tolist(),
            "power": int(workspace.power),
        },
        "goal": field.goal.tolist(),
        "kappa": float(field.kappa),
        "obstacles": [
            {"centre": [x, y], "semi_axes": [a, b], "angle": angle, "exponent": w}
            for (x, y, a, b, angle), w in zip(
                obstacles.theta.tolist(), obstacles.powers.tolist(), strict=True
            )
        ],
    }


def field_from_mapping(
    data: dict[str, Any], source: str = "field block"
) -> NavigationField:
    """The inverse of `field_to_mapping`; raises SkillFileError naming the key."""
    file = Block({"field": data}, source, error=SkillFileError)
    block = file.take_block("field")
    field = take_field(block)
    block.finish()
    return field


def chains_to_mapping(chains: Sequence[Chain]) -> list[dict[str, Any]]:
    """Chains as the list of plain values of their `field` block."""
    items = []
    for branch, chain in enumerate(chains):
        for k, field in enumerate(chain.fields):
            item = field_to_mapping(field)
            if k < len(chain.gates):
                gate = chain.gates[k]
                item[GATE] = {
                    "centre": gate.centre.tolist(),
                    "direction": gate.direction.tolist(),
                    "radius": gate.radius,
                }
            if len(chains) > 1:
                item[BRANCH] = branch
            items.append(item)
    return items


def chains_from_mapping(data: Any, source: str = "field block") -> tuple[Chain, ...]:
    """The inverse of `chains_to_mapping`; a single mapping is a chain of one.

    Raises:
        SkillFileError: Naming the key.
    """
    return take_chains(Block({"field": data}, source, error=SkillFileError))


def take_chains(file: Block) -> tuple[Chain, ...]:
    """Takes a file's `field` block, of one field or a list; fails naming the key."""
    if file.is_list("field"):
        return _take_list(file)
    block = file.take_block("field")
    field = take_field(block)
    block.finish()
    return (Chain((field,)),)


def take_field(block: Block) -> NavigationField:
    """Takes a field's keys out of its mapping; what else is there, stays."""
    rim = block.take_block("workspace")
    centre = np.array(rim.take_list("centre", float, 2))
    semi_axes = np.array(rim.take_list("semi_axes", float, 2))
    power = rim.take("power", int)
    rim.finish()
    goal = np.array(block.take_list("goal", float, 2))
    kappa = block.take("kappa", float)
    rows: list[list[float]] = []
    exponents: list[float] = []
    for item in block.take_blocks("obstacles"):
        row = item.take_list("centre", float, 2) + item.take_list("semi_axes", float, 2)
        rows.append([*row, item.take("angle", float)])
        exponents.append(item.take("exponent", float))
        item.finish()
    key = "workspace"
    try:
        workspace = Workspace(centre, semi_axes, power)
        key = "obstacles"
        obstacles = ObstacleSet(np.array(rows).reshape(-1, 5), np.array(exponents))
        key = ""
        return NavigationField(workspace, goal, kappa, obstacles)
    except ValueError as problem:
        block.fail(key, str(problem))


def _take_list(file: Block) -> tuple[Chain, ...]:
    blocks = file.take_blocks("field")
    if not blocks:
        file.fail("field", "found no fields, expected at least one")
    fields: list[list[NavigationField]] = []
    gates: list[list[Gate]] = []
    open_end = True
    for i, block in enumerate(blocks):
        branch = block.take(BRANCH, int) if block.has(BRANCH) else 0
        # Where the last field had no gate, the next one begins a branch.
        if branch != len(fields) - (0 if open_end else 1):
            block.fail(BRANCH, _branch_problem(branch, len(fields), open_end))
        if open_end:
            fields.append([])
            gates.append([])
        fields[-1].append(take_field(block))
        open_end = block.take_null(GATE) or not block.has(GATE)
        if not open_end:
            gates[-1].append(_take_gate(block.take_block(GATE)))
        block.finish()
        if not open_end and i == len(blocks) - 1:
            block.fail(GATE, "found a gate, but no field follows it")
    try:
        return tuple(map(Chain, map(tuple, fields), map(tuple, gates)))
    except ValueError as problem:
        file.fail("field", str(problem))


def _branch_problem(found: int, begun: int, open_end: bool) -> str:
    expected = begun if open_end else begun - 1
    why = "the field before has no gate" if open_end else "the field before has a gate"
    if not begun:
        why = "branches are numbered from 0"
    return f"found {found}, expected {expected}: {why}"


def _take_gate(block: Block) -> Gate:
    centre = np.array(block.take_list("centre", float, 2))
    direction = np.array(block.take_list("direction", float, 2))
    radius = block.take("radius", float)
    block.finish()
    try:
        return Gate(centre, direction, radius)
    except ValueError as problem:
        block.fail("", str(problem))
