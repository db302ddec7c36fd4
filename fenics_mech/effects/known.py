"""The effects of the program: parts of the equation of poses, and terms that come with what a scene states."""

from __future__ import annotations

from fenics_mech.effects.effect import Effect
from fenics_mech.effects.shear import missing_data

COUPLING, VIBRATION, GRAVITY = "coupling", "vibration", "gravity"
SHEAR, EXACT_STRAINS, STIFFENING = "shear", "large-rotations", "geometric-stiffness"

KNOWN = (
    Effect(
        name="air-drag",
        meaning="drag of the air by the square of the members' velocity",
        source="Morison, O'Brien, Johnson and Schaaf, Petroleum Transactions AIME 189 (1950) 149, without the inertia",
        stated=lambda scene: scene.damping.air is not None,
        stated_by="[damping.air]",
    ),
    Effect(
        name=COUPLING,
        meaning="Coriolis, centrifugal and Euler forces on the elastic displacement",
        source="(4.59)-(4.66), which (5.1) drops",
        couples=True,
    ),
    Effect(
        name="dampers",
        meaning="viscous dampers between points, and viscous friction of joints",
        source="the rate of a line between two moving points",
        stated=lambda scene: bool(scene.dampers),
        stated_by="[dampers]",
    ),
    Effect(
        name="damping",
        meaning="stress that goes with the strain's rate, and drag in proportion to the mass",
        source="Clough and Penzien, Dynamics of Structures, sections 17-3 and 12-5",
        stated=lambda scene: bool(scene.damping.material or scene.damping.external or scene.damping.relative),
        stated_by="[damping] with material, external or relative",
    ),
    Effect(
        name=STIFFENING,
        meaning="bending stiffness from the axial force of loads and rigid motion",
        source="section 7.4; Przemieniecki (1968), ch. 15",
        stress_stiffening=True,
        refuses=(EXACT_STRAINS,),
        loads_at_nodes=True,
    ),
    Effect(
        name=GRAVITY,
        meaning="weight of links, bodies and point masses",
        source="d'Alembert's principle; (4.17) less g",
        stated=lambda scene: any(scene.gravity),
        stated_by="gravity = [...]",
    ),
    Effect(
        name="impulses",
        meaning="impulses at points of the links, at given drive angles",
        source="Lagrange's equations integrated over an instant; Goldsmith, Impact (1960), ch. 2",
        stated=lambda scene: bool(scene.impulses),
        stated_by="[impulses]",
    ),
    Effect(
        name=EXACT_STRAINS,
        meaning="exact strains: bending shortens a member, axial forces act on its bent axis",
        source="Reissner (1972); Simo and Vu-Quoc, J. Appl. Mech. 53 (1986) 849",
        stress_stiffening=True,
        nonlinear=True,
        replaces=STIFFENING,
        refuses=(STIFFENING,),
        loads_at_nodes=True,
    ),
    Effect(
        name="loads",
        meaning="forces and moments at points of the links and along their members",
        source="(4.39); load stiffness: Bolotin, Nonconservative Problems of the Theory of Elastic Stability (1963)",
        stated=lambda scene: bool(scene.loads),
        stated_by="[loads]",
    ),
    Effect(
        name="lumped-mass",
        meaning="half of each element's mass at each of its nodes",
        source="Sadler and Sandor (1973), Sandor and Zhuang (1985): refs. 37 and 39",
    ),
    Effect(
        name="motor",
        meaning="twist of the shaft between the drive and its crank, and inertia of the rotor",
        source="Lagrange's equation of the crank's angle",
        couples=True,
        stated=lambda scene: any(drive.motor is not None for drive in scene.drives),
        stated_by="[drive.motor]",
    ),
    Effect(
        name="rotary-inertia",
        meaning="inertia of the rotation of the beams' sections",
        source="Rayleigh, The Theory of Sound, section 162",
    ),
    Effect(
        name=SHEAR,
        meaning="shear flexibility of the beams",
        source="Timoshenko (1921); Friedman and Kosmatka, Comput. Struct. 47 (1993) 473",
        missing_data=missing_data,
        loads_at_nodes=True,
    ),
    Effect(
        name="springs",
        meaning="springs between points, and torsional springs at joints",
        source="Przemieniecki (1968), ch. 15, for the tangent",
        stated=lambda scene: bool(scene.springs),
        stated_by="[springs]",
    ),
    Effect(
        name=VIBRATION,
        meaning="inertia of the elastic motion; without it the response is quasi-static",
        source="(5.1)",
        stated=lambda scene: scene.analysis.method in ("periodic", "transient"),
        stated_by="analysis.method = 'periodic' or 'transient'",
    ),
)
