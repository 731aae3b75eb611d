"""The stroke laid on the true skin."""

from dataclasses import dataclass

import numpy as np

from bath_drake.carer.stroke import Stroke
from bath_drake.errors import ScenarioError
from bath_drake.notation import FloatArray
from bath_drake.patient.skin import TrueSkin

_STEP_S = 0.01
# A hand does not turn with every facet of the mesh: normals are smoothed over this.
_TURNING_S = 0.2


@dataclass(frozen=True, eq=False)
class SkinPath:
    """Where the marker touches the skin, over time, in the person's frame M.

    Attributes:
        times: (n,) s, from 0, evenly spaced.
        contacts: (n, 3) m.
        normals: (n, 3) unit, out of the body, smooth in time.
    """

    times: FloatArray
    contacts: FloatArray
    normals: FloatArray

    def contact(self, t: float) -> FloatArray:
        """The point (3,) of the skin at time t, m; at rest before and after."""
        return _interpolated(t, self.times, self.contacts)

    def normal(self, t: float) -> FloatArray:
        """The hand's outward direction (3,) at time t, unit."""
        normal = _interpolated(t, self.times, self.normals)
        return np.asarray(normal / np.linalg.norm(normal))


def lay_on_skin(stroke: Stroke, skin: TrueSkin) -> SkinPath:
    """Lays a stroke on a person's back.

    Raises:
        ScenarioError: If part of the stroke is beside the back.
    """
    times = np.arange(0.0, stroke.duration + _STEP_S, _STEP_S)
    p_N = stroke.at(times)
    contacts, met = skin.under(p_N)
    on_back = met.copy()
    on_back[met] = skin.on_back(contacts[met])
    if not on_back.all():
        k = int(np.argmin(on_back))
        raise ScenarioError(
            f"carer: the stroke leaves the back of {skin.person.name} at "
            f"{times[k]:.2f} s, canonical ({p_N[k, 0]:.2f}, {p_N[k, 1]:.2f})"
        )
    _, _, normals = skin.nearest(contacts)
    return SkinPath(times, contacts, _smoothed(normals))


def _smoothed(normals: FloatArray) -> FloatArray:
    half = round(_TURNING_S / _STEP_S / 2.0)
    window = np.hanning(2 * half + 3)[1:-1]
    padded = np.pad(normals, ((half, half), (0, 0)), mode="edge")
    columns = [np.convolve(c, window / window.sum(), mode="valid") for c in padded.T]
    smooth = np.stack(columns, axis=1)
    return np.asarray(smooth / np.linalg.norm(smooth, axis=1, keepdims=True))


def _interpolated(t: float, times: FloatArray, values: FloatArray) -> FloatArray:
    return np.array([np.interp(t, times, column) for column in values.T])
