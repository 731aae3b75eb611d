"""When the motion along the skin stands still."""

from pydrake.systems.framework import Context, InputPort

from bath_drake.control.approach import Phase
from bath_drake.systems._ports import eval_scalar


def stands_still(phase: InputPort, hold: InputPort, context: Context) -> bool:
    """Whether `hold` is above one half or `phase` is not WASH; unconnected: neither."""
    if hold.HasValue(context) and eval_scalar(hold, context) > 0.5:
        return True
    return phase.HasValue(context) and eval_scalar(phase, context) != Phase.WASH
