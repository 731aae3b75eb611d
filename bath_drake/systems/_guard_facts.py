"""The ports through which a guard learns its facts."""

from math import isfinite
from typing import Any

from pydrake.common.value import Value
from pydrake.systems.framework import Context, InputPort, LeafSystem

from bath_drake.perception.body_observation import BodyObservation
from bath_drake.safety.facts import LOST_TIME, GuardFacts
from bath_drake.safety.reasons import Reason
from bath_drake.systems._ports import eval_value, eval_vector

# Optional ports and their sizes. Unconnected, nobody watches that.
OPTIONAL_PORTS = {
    "frame_status": 3,  # share of invalid pixels; 1 if frozen; 1 if stamps went back
    "camera_status": 1,  # share of the arm's pixels that show what is behind it
    "map_status": 1,
    "body_status": 2,  # speed of the skin, m/s; how many people
    "surface_status": 1,
    "surface_normal": 3,
    "world_status": 1,
    "ik_status": 1,
    "self_distance": 1,  # m
    "obstacle_distance": 1,  # m
    "nozzle_clearance": 1,  # m
    "command_stamp": 1,  # s
    "wrench": 7,  # stamp (s); torque (N m), force (N)
    "loop_seconds": 1,
    "robot_stamp": 1,  # s
    "following_error": 1,  # rad
    "reset": 1,
    "other_reason": 1,  # a Reason of another guard
}


_REASONS = {float(reason): reason for reason in Reason}


class FactPorts:
    """Declares the ports on a system and reads them."""

    def __init__(self, system: LeafSystem) -> None:
        """Declares `body_observation` and the optional ports on `system`."""
        self._observation = system.DeclareAbstractInputPort(
            "body_observation", Value[object]()
        )
        self._ports: dict[str, InputPort] = {
            name: system.DeclareVectorInputPort(name, size)
            for name, size in OPTIONAL_PORTS.items()
        }

    def read(self, context: Context, condition_number: float) -> GuardFacts:
        """What is known now; what is not connected is left as not watched."""
        observation = eval_value(self._observation, context, BodyObservation)
        now = context.get_time()
        found: dict[str, Any] = {}
        given = {
            name: eval_vector(port, context).tolist()
            for name, port in self._ports.items()
            if port.HasValue(context)
        }
        for port, fact in (
            ("map_status", "map_believed"),
            ("surface_status", "surface_found"),
            ("world_status", "world_sound"),
            ("reset", "reset"),
        ):
            if port in given:
                found[fact] = given[port][0] > 0.5
        # 0 is well there; NaN is not below one half either.
        if "ik_status" in given:
            found["joint_solution"] = given["ik_status"][0] < 0.5
        if "camera_status" in given:
            (found["seen_through"],) = given["camera_status"]
        for fact in (
            "self_distance",
            "obstacle_distance",
            "nozzle_clearance",
            "loop_seconds",
            "robot_stamp",
            "following_error",
        ):
            if fact in given:
                (found[fact],) = given[fact]
        if "frame_status" in given:
            share, frozen, back = given["frame_status"]
            found |= {
                "invalid_share": share,
                "frame_frozen": not frozen < 0.5,
                "frame_stamp_bad": not back < 0.5,
            }
        if "body_status" in given:
            speed, bodies = given["body_status"]
            whole = int(bodies) if isfinite(bodies) else 0
            found |= {"body_speed": speed, "bodies": whole}
        if "command_stamp" in given:
            found["command_age"] = now - given["command_stamp"][0]
        if "wrench" in given:
            stamp, *wrench = given["wrench"]
            found |= {"wrench_stamp": stamp, "wrench": tuple(wrench)}
        if "surface_normal" in given:
            found["normal_W"] = tuple(given["surface_normal"])
        if "other_reason" in given:
            found["reported"] = (_reason(given["other_reason"][0]),)
        return GuardFacts(
            now=now,
            frame_stamp=observation.stamp,
            body_found=observation.found,
            body_lost=observation.lost(LOST_TIME),
            condition_number=condition_number,
            **found,
        )


def _reason(number: float) -> Reason:
    return _REASONS.get(number, Reason.FACT_NOT_FINITE)
