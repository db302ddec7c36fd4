"""What the keys of a scene mean, in words: editors show them by the JSON Schema, and the reference is made of them."""

from __future__ import annotations

import inspect
import keyword
from itertools import pairwise
from typing import Any

from fenics_mech.scene.base import Part
from fenics_mech.scene.first_error import tables

# What keys mean whose classes do not say it: by class and key, or by the key alone.
MEANINGS = {
    "Scene.drawing": "A drawing that gives links, joints and ground: a file, or a table of `file`, `unit` and so on.",
    "PointMass.mass": "Mass.",
    "PointMass.inertia": "Moment of inertia that turns with the link.",
    "kind": "Names this kind of table.",
    "shape": "Names this shape of section.",
    "material": "Name of a material.",
    "section": "Name of a section; at a drawn link, of all its members.",
    "mesh": "Elements of this member; at a drawn link, of all its members.",
    "points": "Points by name, in the frame of the body.",
    "ends": "Names of the points at its first and second end.",
    "connect": "The points that it connects, as `link.point`.",
    "at": "Point, joint, or place along a member, as `link.point`, `joint` or `member@0.3`.",
    "cosine": "Amplitudes of the cosines, first harmonic first.",
    "sine": "Amplitudes of the sines, first harmonic first.",
    "mean": "Mean over the cycle.",
    "angles": "Angles of the values.",
    "times": "Times of the values.",
    "values": "Values; of a law equally spaced over the cycle.",
    "formula": "Formula of `theta`; of a run-up, of the time `t`.",
    "outline": "Corners of the outline.",
    "holes": "Corners of each hole.",
    "thickness": "Thickness.",
}
OTHER = {  # keys of tables that have no class
    "strain": "Largest error of strains, relative to the largest of their member.",
    "deflection": "Largest error of deflections, relative to the largest of their member.",
    "joint_force": "Largest error of joint forces, relative to the largest of their joint.",
    "torque": "Largest error of the drive's torque, relative to its largest.",
    "file": "The drawing: a .geo script or a .msh mesh of gmsh, beside the scene file.",
    "unit": "Unit of the drawing's coordinates, such as `mm`.",
    "section": "Name of the section of all members.",
    "material": "Name of the material of all members.",
}
QUANTITY = ", or a string with a unit"  # ends what pydantic says of a quantity, after its unit


def meaning_of(part: type, key: str) -> str:
    """Give what a key of a table means, or nothing where neither the docstrings of its class nor `MEANINGS` say it."""
    name = f"{key}_" if keyword.iskeyword(key) else key  # as "from" and "yield"
    for kind in part.__mro__:
        if issubclass(kind, Part) and name in (said := _parameters(kind)):
            return said[name]
    return MEANINGS.get(f"{part.__name__}.{key}") or MEANINGS.get(key, "")


def _parameters(kind: type) -> dict[str, str]:
    """Read the section Parameters of a class's docstring."""
    _, _, section = inspect.cleandoc(kind.__doc__ or "").partition("Parameters\n----------\n")
    found: dict[str, str] = {}
    names: list[str] = []
    for line, after in pairwise([*section.splitlines(), ""]):
        if after.startswith("---"):
            break  # another section begins
        if line and not line.startswith(" "):
            names = [name.strip() for name in line.partition(" :")[0].split(",")]
        elif names:
            found |= {name: f"{found.get(name, '')} {line.strip()}".strip() for name in names}
    return found


def described(schema: dict[str, Any]) -> dict[str, Any]:
    """Put into a JSON Schema of scenes what each key means."""
    classes = {kind.__name__: kind for kind in tables(Part)}
    for table in _tables_in(schema):
        part = classes.get(table.get("title", ""), Part)
        for key, value in table["properties"].items():
            said = meaning_of(part, key) or OTHER.get(key, "")
            value["description"] = _joined(said, value.get("description", ""))
    return schema


def _tables_in(schema: Any) -> list[dict[str, Any]]:
    """Give all tables with keys in a schema, but those of PETSc's options, which say by themselves what they are."""
    inside = schema.values() if isinstance(schema, dict) else schema if isinstance(schema, list) else ()
    found = [table for part in inside for table in _tables_in(part)]
    if isinstance(schema, dict) and isinstance(keys := schema.get("properties"), dict) and "$ref" not in keys:
        found.append(schema)
    return found


def _joined(meaning: str, quantity: str) -> str:
    """Put together what a key means and what is said of its quantity."""
    if not quantity.endswith(QUANTITY) or not meaning:
        return meaning or quantity
    unit = quantity.removesuffix(QUANTITY)
    return f"{meaning} {'A number' if unit == '1' else f'A number in {unit}'}{QUANTITY}."
