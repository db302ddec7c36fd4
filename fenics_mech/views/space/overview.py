"""The overview of a scene in space, which `check` prints: what it holds, in SI, and how it can move."""

from __future__ import annotations

import math
from collections.abc import Iterator

from rich.console import Group
from rich.markup import escape
from rich.text import Text

from fenics_mech.machine.spatial import spatial_machine
from fenics_mech.scene.in_space import SpatialForce, SpatialJoint, SpatialScene
from fenics_mech.views.tables import drive_of, number, table_of


def spatial_overview(scene: SpatialScene) -> Group:
    """Tell what is in a scene in space, its stiffnesses in SI, and how it moves where no link bends.

    Raises
    ------
    SceneError
        When something can move that nothing drives.
    """
    made = spatial_machine(scene)
    counted = {"links": len(scene.links), "joints": len(scene.joints), "point masses": len(scene.masses)}
    counts = ", ".join(f"{count} {name}" for name, count in counted.items() if count)
    members = table_of("Members", "member", "length (m)", "section", "material", "elements", "up")
    stiff = table_of("The same in SI", "member", "mass (kg)", "EA (N)", "EI first (N m^2)", "EI second", "GJ (N m^2)")
    for own in made.members:
        section, up = own.section, own.stated.up
        sizes = f"{own.length:.6g}", own.stated.section, own.stated.material, str(len(own.elements))
        members.add_row(escape(own.label), *sizes, "any" if up is None else _way(up))
        bending = (number(own.modulus * inertia) for inertia in section.inertia)
        mass, torsion = own.density * section.area * own.length, own.shear_modulus * section.torsion
        stiff.add_row(escape(own.label), number(mass), number(own.modulus * section.area), *bending, number(torsion))
    joints = table_of("Joints", "joint", "kind", "connects", "axis")
    for name, joint in scene.joints.items():
        joints.add_row(escape(name), joint.kind, " - ".join(joint.connect), _axis(joint))
    tables = [members, stiff] if made.members else []
    lines = [f"{counts}; {drive_of(scene)}", *_acting(scene)]
    lines.append(f"Mobility {made.freedoms}, without drives, where no link bends.")
    for link in made.idle.values():
        lines.append(f"Link {link} may turn about its own line, which nothing drives: a row holds that turn.")
    if made.redundant:
        lines.append(f"Joints that hold more than is needed where links do not bend: {', '.join(made.redundant)}.")
    said = [Text(line) for line in lines]
    return Group(Text(scene.name, style="bold"), said[0], *tables, *([joints] if scene.joints else []), *said[1:])


def _way(way: tuple[float, float, float]) -> str:
    return f"({', '.join(f'{part:g}' for part in way)})"


def _axis(joint: SpatialJoint) -> str:
    """Directions of a joint, and how it is misaligned."""
    ways = " and ".join(_way(way) for way in (joint.axis, *(joint.axes or ())) if way is not None)
    if joint.misaligned is None:
        return ways
    return f"{ways}, askew by {math.degrees(joint.misaligned.by):.4g} deg about {_way(joint.misaligned.about)}"


def _acting(scene: SpatialScene) -> Iterator[str]:
    """Say which rigid links, masses, loads, springs and dampers there are, in SI."""
    for name, link in scene.links.items():
        if link.rigid is not None:
            yield f"link {name} is rigid: mass {number(link.rigid.mass)} kg"
    for name, mass in scene.masses.items():
        yield f"mass {name}: {number(mass.mass)} kg at {mass.at}"
    for name, load in scene.loads.items():
        if isinstance(load, SpatialForce):
            yield f"load {name}: {_way(load.force)} N at {load.at}"
        else:
            said = f"{load.push:g} N along" if load.push else f"{load.torque:g} N m about"
            yield f"load {name}: {said} the axis of joint {load.joint}"
    for kind in ("springs", "dampers"):
        if names := ", ".join(getattr(scene, kind)):
            yield f"{kind}: {names}"
    yield f"gravity: {_way(scene.gravity)} m/s^2" if any(scene.gravity) else "gravity: none is stated"
