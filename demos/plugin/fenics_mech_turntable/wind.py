"""Wind on a member: its drag as a load along the member."""

import math
from typing import Annotated, Any, Literal

from pydantic import Field

from fenics_mech.scene.applied_loads import LineLoad
from fenics_mech.scene.units import Density, Length, LineForce, Speed


class WindLoad(LineLoad):
    """Drag of a steady wind on a member, whose own motion is slow against it.

    Parameters
    ----------
    member
        "link", or "link.member" when the link has several members.
    wind
        Velocity of the wind along X and Y (m/s).
    breadth
        Size of the member normal to the plane of motion (m).
    drag
        Coefficient of drag.
    air
        Density of the air (kg/m^3).
    line
        Follows from the other keys.
    """

    kind: Literal["wind"] = "wind"
    wind: tuple[Speed, Speed]
    breadth: Annotated[Length, Field(gt=0)]
    drag: Annotated[float, Field(ge=0)] = 2.0
    air: Density = 1.2
    line: tuple[LineForce, LineForce] = (0.0, 0.0)

    def computed(self) -> dict[str, Any]:
        """Give the force per length, c rho b |v| v/2 (N/m)."""
        size = self.drag * self.air * self.breadth * math.hypot(*self.wind) / 2
        return {"line": (size * self.wind[0], size * self.wind[1])}
