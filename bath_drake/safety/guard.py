"""The guard's decision: pass, hold, retreat or stop, and why.

A state machine apart from any system. `guard_step` is called once a control tick with
all that is known, the answer of the command's own check included (`reported`). What a
reason leads to, and what ends it, stands in `bath_drake.safety.reasons`:

* the mode is that of the gravest reason there is; STOP goes before RETREAT, HOLD, PASS;
* STOP is left by a reset alone, and a reset leads no further than HOLD;
* HOLD passes again once all has been well for the dwell time, and, if any reason met
  since the last pass does not resume by itself, only after a reset;
* RETREAT goes on for its distance, whatever else is well by then, and ends in HOLD; the
  distance is given once between two passes.

A reset is the rise of a level, seen while the loop runs: one that is held does nothing.
This is research software, not a certified safety function.
"""

from dataclasses import dataclass, field
from math import hypot, inf, isfinite

from bath_drake.safety.facts import (
    ROUNDING,
    GuardFacts,
    Memory,
    Vector,
    present_reasons,
    remember,
)
from bath_drake.safety.limits import GuardLimits, retreat_way
from bath_drake.safety.reasons import RESPONSES, Mode, Reason


@dataclass(frozen=True, kw_only=True)
class GuardState:
    """What the guard remembers.

    Attributes:
        mode: Of the last tick.
        reason: Why. Once all is well again: what only a reset ends, or the last one
            there was.
        present: The gravest reason there was at the last tick, NONE if all was well.
        locked_by: The first reason met that only a reset ends; NONE if there is none.
        well_since: When all began to be well, s; infinite while it is not.
        retreated: For how long it has retreated since it last passed, s.
        normal_W: The way to retreat: the last normal known.
        reset: The reset's level at the last tick; the first tick has none before.
        memory: What the next tick's facts are compared with.
        counts: How often each reason began, by its number.
    """

    mode: Mode = Mode.HOLD
    reason: Reason = Reason.NO_FRAME
    present: Reason = Reason.NO_FRAME
    locked_by: Reason = Reason.NONE
    well_since: float = inf
    retreated: float = 0.0
    normal_W: Vector | None = None
    reset: bool = True
    memory: Memory = field(default_factory=Memory)
    counts: Vector = (0.0,) * len(Reason)


@dataclass(frozen=True, kw_only=True)
class Decision:
    """What is to be done at this tick.

    Attributes:
        mode: Only under PASS may a checked command go on.
        reason: Why not PASS; NONE under PASS.
        normal_W: The way to go under RETREAT, unit; None otherwise.
    """

    mode: Mode
    reason: Reason
    normal_W: Vector | None = None


def gravest(reasons: list[Reason]) -> Reason:
    """The first of those with the greatest mode; NONE of none."""
    return max(reasons, key=lambda r: RESPONSES[r].mode, default=Reason.NONE)


def guard_step(
    state: GuardState, facts: GuardFacts, limits: GuardLimits
) -> tuple[GuardState, Decision]:
    """One tick: what to do, and what to remember.

    Args:
        state: Of the last tick; `GuardState()` before the first, which holds.
        facts: What is known now.
        limits: What to keep to.
    """
    reasons = list(present_reasons(state.memory, facts, limits))
    reason = gravest(reasons)
    wanted = RESPONSES[reason].mode
    was_reset = facts.reset and not state.reset
    # Met now, a reason locks again; it is not forgiven by a reset of the same tick.
    locked_by = Reason.NONE if was_reset else state.locked_by
    if locked_by is Reason.NONE:
        locked_by = gravest([r for r in reasons if not RESPONSES[r].resumes])
    ticked = facts.now - state.memory.now
    # The first tick, and a clock that is none or went back, take no time.
    elapsed = ticked if isfinite(ticked) and ticked > 0.0 else 0.0
    normal = _unit(facts.normal_W) or state.normal_W

    well_since, retreated = inf, state.retreated
    if wanted is Mode.PASS:
        well_since = min(state.well_since, facts.now)
    dwelt = facts.now - well_since >= limits.loop.resume_time - ROUNDING
    if state.mode is Mode.RETREAT:
        retreated += elapsed
    way = retreat_way(limits).seconds
    retreats = normal is not None and retreated < way - ROUNDING

    if wanted is Mode.STOP or (state.mode is Mode.STOP and not was_reset):
        mode = Mode.STOP
    elif retreats and Mode.RETREAT in (wanted, state.mode):
        mode = Mode.RETREAT
    elif (
        wanted is Mode.PASS
        and not locked_by
        and (state.mode is Mode.PASS or (state.mode is Mode.HOLD and dwelt))
    ):
        mode, retreated = Mode.PASS, 0.0
    else:
        mode = Mode.HOLD

    if mode is Mode.PASS:
        shown = Reason.NONE
    elif reason is Reason.NONE and mode is Mode.HOLD:
        shown = locked_by or state.reason
    elif RESPONSES[reason].mode < mode:
        shown = state.reason  # what began it and is over
    else:
        shown = reason
    counts = state.counts
    if shown not in (state.reason, Reason.NONE):
        counts = tuple(n + (k == shown) for k, n in enumerate(counts))
    after = GuardState(
        mode=mode,
        reason=shown,
        present=reason,
        locked_by=locked_by,
        well_since=well_since,
        retreated=retreated,
        normal_W=normal,
        reset=facts.reset,
        memory=remember(state.memory, facts),
        counts=counts,
    )
    return after, Decision(
        mode=mode, reason=shown, normal_W=normal if mode is Mode.RETREAT else None
    )


def _unit(normal: Vector | None) -> Vector | None:
    """The normal if it is one: three numbers of length one up to rounding."""
    if normal is None or len(normal) != 3 or not all(map(isfinite, normal)):
        return None
    return normal if abs(hypot(*normal) - 1.0) < 1e-6 else None
