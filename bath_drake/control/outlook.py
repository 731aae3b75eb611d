"""The worlds of the field that is followed and of the next, made ahead of time.

A world takes hundredths of a second to join and to prove. Made while the field before
is followed, it is there when the motion passes the gate, and the robot need not wait.
"""

from dataclasses import dataclass, replace

from bath_drake.composition.chain import Chain
from bath_drake.control.areas import contain, inflated
from bath_drake.control.staging import entry_point
from bath_drake.control.world import World, join_areas
from bath_drake.field.navigation import NavigationField
from bath_drake.field.obstacles import ObstacleSet, Workspace
from bath_drake.notation import FloatArray
from bath_drake.shared import Shared


@dataclass(frozen=True, eq=False)
class Outlook(Shared):
    """Areas in force and the worlds that were made for them.

    Attributes:
        areas: Restricted areas in N, with some slack.
        worlds: Of the field that was followed when they were made, and of the next.
        rim: Of the body, in N, that they were asked to be within; None if none was.
    """

    areas: ObstacleSet
    worlds: tuple[World, ...] = ()
    rim: Workspace | None = None

    def world_of(self, field: NavigationField) -> World | None:
        """The world that was made for a learned field, if there is one."""
        return next((w for w in self.worlds if w.learned == field), None)


def look_ahead(
    outlook: Outlook | None,
    areas: ObstacleSet,
    chain: Chain,
    point: FloatArray,
    *,
    slack: float,
    rim: Workspace | None = None,
) -> Outlook:
    """Makes the world that is needed most, one at most: a frame has little time.

    Args:
        outlook: What there is; None at first.
        areas: Restricted areas as seen now. Those in force hold, and the worlds with
            them, as long as they contain these.
        chain: The field that is followed and those to come.
        point: (2,) where the motion is, in N.
        slack: Added to the areas' semi-axes when they come into force.
        rim: Of the body, in N; None where it is not known.

    Returns:
        The outlook itself where nothing was to be made.
    """
    if outlook is None or not contain(outlook.areas, areas):
        outlook = Outlook(inflated(areas, slack), rim=rim)
    elif outlook.rim != rim:
        outlook = Outlook(outlook.areas, rim=rim)
    now = outlook.world_of(chain.fields[0])
    if now is None:
        world = join_areas(chain.fields[0], outlook.areas, point, rim)
        return replace(outlook, worlds=(world,))
    if len(chain) == 1 or outlook.world_of(chain.fields[1]) is not None:
        return outlook
    driven = Chain((now.field, chain.fields[1]), chain.gates[:1])
    entry = entry_point(point, driven)
    world = join_areas(chain.fields[1], outlook.areas, entry, rim)
    return replace(outlook, worlds=(now, world))
