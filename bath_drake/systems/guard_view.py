"""A lamp in Meshcat that shows what the guard does, as a Drake system."""

from pydrake.geometry import Cylinder, Meshcat, Rgba, Sphere
from pydrake.math import RigidTransform
from pydrake.systems.framework import Context, EventStatus, LeafSystem

from bath_drake.notation import FloatArray
from bath_drake.safety.reasons import Mode
from bath_drake.systems._ports import eval_scalar
from bath_drake.systems._poses import at

# Where Meshcat has the lamp.
ROOT = "/guard"
# Red, green, blue: passes, holds, retreats, has stopped.
COLOURS = {
    Mode.PASS: (0.10, 0.50, 0.29),
    Mode.HOLD: (0.94, 0.89, 0.26),
    Mode.RETREAT: (0.95, 0.56, 0.17),
    Mode.STOP: (0.70, 0.15, 0.12),
}
_RADIUS, _POST = 0.035, 0.008  # m


class GuardView(LeafSystem):
    """Shows the joint guard's mode: green, yellow, orange or red.

    .. pydrake_system::

        name: GuardView
        input_ports:
        - guard_mode

    Stateless; publishes at a fixed rate, into Meshcat's recording too.
    """

    def __init__(self, *, meshcat: Meshcat, place: FloatArray, period: float) -> None:
        """Declares the port and draws the lamp, all of it dark.

        Args:
            meshcat: Shows it.
            place: (3,) of the lamp in W, m; it stands on a post from the floor.
            period: Between two views, s.
        """
        super().__init__()
        self._meshcat = meshcat
        self._mode = self.DeclareVectorInputPort("guard_mode", 1)
        height = float(place[2])
        post = at([float(place[0]), float(place[1]), height / 2.0])
        _draw(meshcat, "post", Cylinder(_POST, height), post, (0.4, 0.42, 0.45))
        for mode, colour in COLOURS.items():
            _draw(meshcat, mode.name.lower(), Sphere(_RADIUS), at(place), colour)
            meshcat.SetProperty(f"{ROOT}/{mode.name.lower()}", "visible", False)
        self.DeclarePeriodicPublishEvent(period, 0.0, self._show)

    def _show(self, context: Context) -> EventStatus:
        now = eval_scalar(self._mode, context)
        for mode in COLOURS:
            path = f"{ROOT}/{mode.name.lower()}"
            self._meshcat.SetProperty(path, "visible", now == mode, context.get_time())
        return EventStatus.Succeeded()


def _draw(
    meshcat: Meshcat,
    name: str,
    shape: Sphere | Cylinder,
    X_WL: RigidTransform,
    rgb: tuple[float, float, float],
) -> None:
    meshcat.SetObject(f"{ROOT}/{name}", shape, Rgba(*rgb, 1.0))
    meshcat.SetTransform(f"{ROOT}/{name}", X_WL)
