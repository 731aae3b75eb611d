"""Whether a scenario's arm gets all over its path, said before anything moves."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from bath_drake.diagrams.control import guard_limits
from bath_drake.learning.skill import Skill
from bath_drake.patient.people import load_person
from bath_drake.reach.along_path import Manner, along
from bath_drake.reach.back import true_back
from bath_drake.reach.clearance import body_points
from bath_drake.reach.judge import BEHIND_M, Cause, Places, worst
from bath_drake.reach.kinematics import ArmModel
from bath_drake.reach.over_back import over
from bath_drake.reach.path import driven_path
from bath_drake.reach.placement import (
    Placement,
    PlacementMap,
    placement_map,
    search_placement,
)
from bath_drake.safety.limits import GuardLimits
from bath_drake.safety.obstacle_distance import FAR
from bath_drake.scenario import Scenario


@dataclass(frozen=True, eq=False)
class Reachability:
    """What of a path and a back is reached, and from where there would be more.

    Attributes:
        path: The places of the skill's path, with the person as twisted and leant as
            it gets, all along: the worst of it.
        rest: The same with the person at rest.
        back: A grid all over the back, row after row; None if it was not asked for.
        here: Where the base stands; None if no other place was looked for.
        best: The best place found.
        map: Places of the base and what they are worth; None if not asked for.
        limits: The guard's, which all was judged by.
    """

    path: Places
    rest: Places
    back: Places | None
    here: Placement | None
    best: Placement | None
    map: PlacementMap | None
    limits: GuardLimits

    def lines(self) -> list[str]:
        """What is to be told, a line; a second one if a better place was looked for."""
        lines = [f"reach:   {_path_words(self.path, self.rest, self.limits)}"]
        if self.here is not None and self.best is not None:
            lines.append(f"base:    {_base_words(self.here, self.best)}")
        return lines

    def metrics(self) -> dict[str, Any]:
        """For metrics.json: plain values, lengths in m, angles in rad."""
        slow = self.limits.joints.condition_slow
        path, back = self.path, self.back
        return {
            "path": {
                "reached": path.reached,
                "reached_at_rest": self.rest.reached,
                "share": path.share,
                "condition": _most(path.condition),
                "joint_margin": _least(path.margin),
                "self_distance": _least(path.self_distance),
                "obstacle_distance": _least(path.obstacle_distance),
                "not_reached": not_reached(path),
            },
            "back": None
            if back is None
            else {
                "share": back.share,
                "share_at_full_speed": _share(back, slow),
            },
            "better_base": _better(self.here, self.best),
        }


def reachability(
    scenario: Scenario,
    skill: Skill,
    *,
    back: bool = True,
    search: bool | None = None,
    floor: bool = False,
) -> Reachability:
    """Finds out what the arm of a scenario reaches with the person in every pose.

    Args:
        scenario: Person, arm and how to move.
        skill: Whose path is followed.
        back: Whether to go all over the back as well.
        search: Whether to look for a better place of the base; None does so where the
            path is not reached.
        floor: Whether to map places of the base, at the height and yaw of the best one
            found or else of where it stands.

    Raises:
        ScenarioError: If the person is not there, damaged or cannot bend as told.
    """
    scene, control = scenario.scene, scenario.control
    person, limits = load_person(scene.person), guard_limits(scenario)
    arm = ArmModel.of(scene.arm, limits)
    there = true_back(
        scene,
        person,
        given=scenario.perception.restricted_areas,
        margin=scenario.perception.area_margin,
    )
    manner = Manner(
        standoff=control.standoff,
        far_standoff=control.far_standoff,
        approach_speed=control.approach_speed,
        washing_speed=control.washing_speed,
        leash=control.leash,
        limits=limits,
    )
    path_N = driven_path(skill, there.areas, there.half_extents, control.washing_speed)
    paths = along(arm, there, path_N, manner)
    path = worst(paths)
    here = best = plan = None
    body = body_points(scene, person)
    if search or (search is None and not path.reached):
        here, best = search_placement(arm, there, path_N, body, manner)
    if floor:
        plan = placement_map(arm, there, path_N, body, manner, best)
    every = over(arm, there, manner) if back else None
    return Reachability(path, paths[0], every, here, best, plan, limits)


def not_reached(path: Places) -> list[dict[str, Any]]:
    """The parts of a path that are not reached: from, to (in N), and why."""
    parts = []
    begin = 0
    for k in range(1, len(path) + 1):
        if k < len(path) and path.cause[k] == path.cause[begin]:
            continue
        cause = Cause(path.cause[begin])
        if cause > Cause.NO_SKIN:
            ends = (path.p_N[begin], path.p_N[k - 1])
            parts.append(
                {
                    "from": np.round(ends[0], 3).tolist(),
                    "to": np.round(ends[1], 3).tolist(),
                    "cause": cause.words,
                    "condition": float(path.condition[begin:k].max()),
                }
            )
        begin = k
    return parts


def _path_words(path: Places, rest: Places, limits: GuardLimits) -> str:
    parts = not_reached(path)
    joints = limits.joints
    if not parts:
        condition = _most(path.condition) or 0.0
        slow = " (slowed down)" if condition > joints.condition_slow else ""
        return (
            f"the whole path is reached; condition number at most {condition:.0f}{slow}"
            f", {_least(path.margin) or 0.0:.2f} rad from a joint's end, "
            f"links {_off_words(path)}"
        )
    told = "; ".join(
        f"from ({part['from'][0]:.2f}, {part['from'][1]:.2f}) to "
        f"({part['to'][0]:.2f}, {part['to'][1]:.2f}) {part['cause']}"
        for part in parts[:3]
    )
    more = f" and {len(parts) - 3} more parts" if len(parts) > 3 else ""
    where = "" if not rest.reached else " in every pose of the person, at rest all"
    return f"{100.0 * path.share:.1f} % of the path is reached{where}; {told}{more}"


def _off_words(path: Places) -> str:
    gap = _least(path.obstacle_distance)
    more = ">" if gap is None or gap >= FAR else ""
    off = f"{more}{1e3 * (FAR if gap is None else gap):.0f} mm"
    behind = _most(path.place_error) or 0.0
    lag = f" (the nozzle up to {1e3 * behind:.0f} mm off its path for that)"
    told = lag if behind > BEHIND_M else ""
    return f"{off} off person, stool and pedestal{told}"


def _base_words(here: Placement, best: Placement) -> str:
    if not best.better > here.better:
        return "no better place for it was found"
    x, y, z = best.position
    return (
        f"at [{x:.3f}, {y:.3f}, {z:.3f}], yaw {best.yaw:.2f}, "
        f"{100.0 * best.path_share:.0f} % of the path would be reached, condition "
        f"number at most {best.condition:.0f} (here {100.0 * here.path_share:.0f} %, "
        f"{here.condition:.0f})"
    )


def _better(here: Placement | None, best: Placement | None) -> dict[str, Any] | None:
    if here is None or best is None or not best.better > here.better:
        return None
    return {
        "base_position": np.round(best.position, 4).tolist(),
        "base_yaw": best.yaw,
        "path_share": best.path_share,
        "condition": best.condition,
        "clearance": best.clearance,
    }


def _share(places: Places, slow: float) -> float:
    skin = places.cause != Cause.NO_SKIN
    well = (places.cause == Cause.NONE) & (places.condition < slow)
    return float(well[skin].mean()) if skin.any() else 1.0


def _most(values: np.ndarray[Any, Any]) -> float | None:
    known = values[np.isfinite(values)]
    return float(known.max()) if len(known) else None


def _least(values: np.ndarray[Any, Any]) -> float | None:
    known = values[np.isfinite(values)]
    return float(known.min()) if len(known) else None
