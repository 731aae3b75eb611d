"""What the guard is expected to do about a fault, and whether a run shows it."""

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from bath_drake.notation import FloatArray
from bath_drake.safety.reasons import Mode, Reason

GO_ON = "go_on"
REACTIONS = {
    "hold": Mode.HOLD,
    "retreat": Mode.RETREAT,
    "stop": Mode.STOP,
    GO_ON: Mode.PASS,
}
# By then the joints stand: 2.63 rad/s at 10 rad/s^2, s.
BRAKED = 0.27
# Within so long before the condition commands must have passed, s: a run that held
# anyway shows nothing.
_BEFORE = 0.5


@dataclass(kw_only=True)
class Expectation:
    """A row of the fault matrix; a scenario that has one is judged by it."""

    row: int = 0  # of the matrix
    fault: str = ""  # in words
    # s, from when on the condition is there; null: as an area of `faults.areas`
    # reaches the nozzle.
    begins: float | None = 0.0
    ends: float = 3600.0  # s, from when on it is over
    reaction: str = "hold"  # hold, retreat, stop, or go_on
    reasons: list[str] = field(default_factory=list)  # any of these is right
    within: float = 0.1  # s
    resumes: bool = False  # whether it goes on by itself once it is over


def check_expectation(expected: Expectation) -> None:
    """Raises ValueError naming the key that expects nothing, and what is allowed."""
    if expected.row < 0:
        raise ValueError(f"row: found {expected.row}, allowed 0 and up")
    if expected.reaction not in REACTIONS:
        raise ValueError(
            f"reaction: found {expected.reaction[:40]!r}, "
            f"allowed {', '.join(REACTIONS)}"
        )
    known = [reason.name for reason in Reason]
    for name in expected.reasons:
        if name not in known:
            raise ValueError(
                f"reasons: found {name[:40]!r}, allowed {', '.join(known)}"
            )
    if (expected.reaction == GO_ON) == bool(expected.reasons):
        raise ValueError(
            f"reasons: found {len(expected.reasons)}, allowed at least one, and none "
            f"where it goes on"
        )
    begins = 0.0 if expected.begins is None else expected.begins
    if not 0.0 <= begins < expected.ends < math.inf:
        raise ValueError(
            f"begins: found {begins}, allowed 0 and up, before ends ({expected.ends})"
        )
    if not 0.0 < expected.within <= 1.0:
        raise ValueError(f"within: found {expected.within}, allowed up to 1")


def judge_reaction(
    expected: Expectation,
    begins: float | None,
    *,
    time: FloatArray,
    mode: FloatArray,
    reason: FloatArray,
    emitted: FloatArray,
) -> dict[str, Any]:
    """Measures what the joint guard did about a fault.

    Args:
        expected: What it should have done.
        begins: From when on the condition was there, s; None if it never was.
        time: (T,) s, evenly.
        mode: (T,) its modes.
        reason: (T,) its reasons.
        emitted: (T, 14) joint positions and speeds behind it.

    Returns:
        `seconds` to the reaction expected, None if it did not come; `reason`, the
        first there was; `passed_before`, whether commands did shortly before;
        `passed_meanwhile`, at how many samples they did between reaction and end;
        `resumed`; `at_rest`, None where there is no telling; and `finite`.
    """
    found: dict[str, Any] = {
        "seconds": None,
        "reason": None,
        "passed_before": None,
        "passed_meanwhile": None,
        "resumed": None,
        "at_rest": None,
        "finite": bool(np.isfinite(emitted).all()),
    }
    if begins is None:
        return found
    rounding = 1e-6
    after = time >= begins - rounding
    before = ~after & (time > begins - _BEFORE)
    found["passed_before"] = bool((mode[before] == Mode.PASS).any())
    if expected.reaction == GO_ON:
        held = mode[after] != Mode.PASS
        found["passed_meanwhile"] = int(np.count_nonzero(~held))
        first = np.flatnonzero(held)
        found["reason"] = _name(reason[after][first[0]]) if len(first) else None
        found["seconds"] = None if len(first) else 0.0
        found["resumed"] = bool(len(held) and not held[-1])
        return found
    seen = np.flatnonzero(after & (mode != Mode.PASS))
    found["reason"] = _name(reason[seen[0]]) if len(seen) else None
    wanted = [Reason[name] for name in expected.reasons]
    right = after & (mode == REACTIONS[expected.reaction]) & np.isin(reason, wanted)
    if not right.any():
        return found
    k = int(np.argmax(right))
    found["seconds"] = max(float(time[k] - begins), 0.0)
    over = time >= expected.ends - rounding
    meanwhile = (np.arange(len(time)) >= k) & ~over
    found["passed_meanwhile"] = int(np.count_nonzero(mode[meanwhile] == Mode.PASS))
    found["resumed"] = bool((mode[over] == Mode.PASS).any())
    still = meanwhile & (time >= time[k] + BRAKED) & (mode != Mode.RETREAT)
    if expected.reaction != "retreat" and still.any():
        found["at_rest"] = bool(np.abs(emitted[still, 7:]).max() < 1e-9)
    return found


def reaction_checks(
    expected: Expectation, found: dict[str, Any]
) -> dict[str, dict[str, Any]]:
    """Compares a reaction with what was expected: `value`, `limit` and `pass`."""

    def check(value: Any, limit: Any) -> dict[str, Any]:
        return {"value": value, "limit": limit, "pass": value == limit}

    seconds = found["seconds"]
    checks = {
        "reaction_s": {
            "value": seconds,
            "limit": expected.within,
            "pass": seconds is not None and seconds <= expected.within,
        },
        "emitted_finite": check(found["finite"], True),
    }
    # At the very start there is nothing that could have passed.
    if expected.begins is None or expected.begins > 0.5:
        checks["passed_before"] = check(found["passed_before"], True)
    if expected.reaction != GO_ON:
        checks["passed_meanwhile"] = check(found["passed_meanwhile"], 0)
        checks["resumed"] = check(found["resumed"], expected.resumes)
    if found["at_rest"] is not None:
        checks["at_rest"] = check(found["at_rest"], True)
    return checks


def _name(reason: float) -> str:
    return Reason(int(reason)).name
