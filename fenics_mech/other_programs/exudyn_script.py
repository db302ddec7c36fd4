"""A scene as a script for Exudyn: a second opinion for those who want to see each item that it is given."""

from __future__ import annotations

import pprint
from pathlib import Path
from typing import Any

from fenics_mech.other_programs.beam_linkage import Beam, BeamLinkage, exported_linkage
from fenics_mech.scene import Scene

BODY = Path(__file__).with_name("exudyn_body.txt")
HEAD = '''"""{name}: the steady cycle by Exudyn. Written by fenics_mech {version} from a scene file.

Beams, joints and masses in SI, at drive angle 0. Needs exudyn and numpy: `python THIS_FILE [strain.csv]`.
It integrates from the motion of rigid links until the cycle repeats, and gives strains at mid-span on both fibres.
To compare with fenics_mech, analyse the scene with effects = ["coupling", "large-rotations"]
and damping = {{ material = {retardation!r} }} (s), the only damping here.
"""
'''


def exudyn_script(scene: Scene) -> str:
    """Write a scene as a Python script that builds and runs it in Exudyn."""
    from fenics_mech._version import __version__  # noqa: PLC0415

    linkage = exported_linkage(scene)
    name = ascii(scene.name)[1:-1].replace('"', "'")
    head = HEAD.format(name=name, version=__version__, retardation=linkage.retardation)
    tables = [f"{key} = {pprint.pformat(value, width=110, sort_dicts=False)}" for key, value in _data(linkage).items()]
    return head + "\n" + "\n".join(tables) + "\n" + BODY.read_text(encoding="utf-8")


def _data(linkage: BeamLinkage) -> dict[str, Any]:
    """Give the linkage as plain numbers, by the names in the script. An end is the number of its beam, and 0 or -1."""
    return {
        "BEAMS": [_beam(beam) for beam in linkage.beams],
        "WELDS": list(linkage.welds),
        "PINS": list(linkage.pins),
        "SUPPORTS": list(linkage.supports),
        "GUIDES": [(end, normal.tolist()) for end, normal in linkage.guides],
        "MASSES": list(linkage.masses),
        "DRIVE": linkage.drive,
        "SPEED": linkage.speed,
        "RETARDATION": linkage.retardation,
    }


def _beam(beam: Beam) -> dict[str, Any]:
    arrays = {name: getattr(beam, name).tolist() for name in ("ends", "velocities", "fibres")}
    numbers = {name: getattr(beam, name) for name in ("turning", "line_density", "axial", "bending")}
    return {"label": beam.label} | arrays | numbers
