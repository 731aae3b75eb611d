"""A compiled roll-out; for the field's arguments see `bath_drake.field._kernels`."""

import math

from bath_drake.field._boundaries import compiled, crosses, sharpest
from bath_drake.field._kernels import flow, flow_psi
from bath_drake.notation import FloatArray

ARRIVED, TRAPPED, LEFT, OUT_OF_STEPS, PASSED = 0, 1, 2, 3, 4


@compiled
def roll_out(
    x: float,
    y: float,
    workspace: FloatArray,
    gx: float,
    gy: float,
    kappa: float,
    forms: FloatArray,
    step: float,
    tolerance: float,
    gate: FloatArray,
    path: FloatArray,
) -> tuple[int, int, float, float]:
    """Guarded roll-out into ``path`` (T, 2).

    Returns the points written, the status, the least beta and the arc length. It ends
    with PASSED at the first point within the half-disc ``gate`` (centre x, y, unit
    direction x, y, radius); a radius of zero is no gate.
    Midpoint steps of arc length ``step`` (shorter near the goal); a step is
    halved until psi, and with it phi, falls and the whole way to the new point is free.
    """
    path[0, 0] = x
    path[0, 1] = y
    length = 0.0
    fx, fy, clear, value = flow_psi(x, y, workspace, gx, gy, kappa, forms, 0.0, True)
    if not clear > 0.0:  # or not a number
        return 1, LEFT, clear, length
    h = step
    # In an ellipse's own norm, sqrt(beta + 1), a step over it must begin or end within
    # half its length of the boundary; elsewhere there is no need to look.
    tight = (1.0 + 0.5 * step * sharpest(forms)) ** 2 - 1.0
    least = clear
    for n in range(1, path.shape[0] + 1):
        if gate[4] > 0.0:
            ux = x - gate[0]
            uy = y - gate[1]
            ahead = ux * gate[2] + uy * gate[3] >= 0.0
            if ahead and ux * ux + uy * uy <= gate[4] * gate[4]:
                return n, PASSED, clear, length
        distance = math.sqrt((x - gx) * (x - gx) + (y - gy) * (y - gy))
        if distance <= tolerance:
            return n, ARRIVED, clear, length
        if n == path.shape[0]:
            break
        # Grow again after a tight spot, but never beyond the asked step.
        h = min(min(2.0 * h, step), distance)
        while True:
            mx, my, free = flow(
                x + 0.5 * h * fx,
                y + 0.5 * h * fy,
                workspace,
                gx,
                gy,
                kappa,
                forms,
                0.0,
            )
            nx = x + h * mx
            ny = y + h * my
            if free > 0.0:
                # The next step's first direction comes with this one's test.
                ax, ay, free, after = flow_psi(
                    nx, ny, workspace, gx, gy, kappa, forms, 0.0, True
                )
                close = min(least, free) < tight
                if after < value and not (
                    close and crosses(x, y, h * mx, h * my, forms)
                ):
                    break
            h *= 0.5
            # Far below any step worth taking: a critical point holds it.
            if h < 1e-7 * step:
                return n, TRAPPED, clear, length
        x = nx
        y = ny
        fx = ax
        fy = ay
        value = after
        length += h
        least = free
        clear = min(clear, least)
        path[n, 0] = x
        path[n, 1] = y
    return path.shape[0], OUT_OF_STEPS, clear, length
