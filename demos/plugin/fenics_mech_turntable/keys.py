"""Keys of scenes. They stand apart from the effect, so that a scene is read without what the effect imports."""

from fenics_mech.scene.base import Part
from fenics_mech.scene.units import AngularSpeed


class Turntable(Part):
    """Keys of ``[plugins.turntable]``.

    Parameters
    ----------
    speed
        Speed of the turntable (rad/s).
    """

    speed: AngularSpeed
