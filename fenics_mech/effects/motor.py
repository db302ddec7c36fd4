"""A drive whose shaft twists: the whole linkage swings about its nominal motion, see `mechanism.motor_equation`."""

from fenics_mech.effects.effect import Effect
from fenics_mech.effects.terms import Terms

EFFECT = Effect(
    name="motor",
    meaning="twist of the shaft between the drive and its crank, and inertia of the rotor",
    source="Lagrange's equation of the crank's angle, linearised about the motion",
    terms=lambda situation: Terms(coupled=True),
    couples=True,
    solver="motor",
    stated=lambda scene: any(drive.motor is not None for drive in scene.drives),
    stated_by="[drive.motor]",
)
