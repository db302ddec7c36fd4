"""The scene, checked as a whole."""

from __future__ import annotations

from typing import Any

from pydantic import model_validator

from fenics_mech.scene.base import check_texts
from fenics_mech.scene.consistency import check_references
from fenics_mech.scene.load_cases import check_cases
from fenics_mech.scene.scene_data import SceneData

OF_LINKS = ("materials", "sections", "ground", "links", "joints", "masses", "mesh")  # keys that links are made of


class Scene(SceneData):
    """A planar linkage, how it is driven and how it is to be analysed. A scene file has the same keys.

    Parameters
    ----------
    name
        What the linkage is called in plots and reports.
    units
        Units of printed answers, such as ("in", "psi", "lbf"); by default mm, MPa, N and so on.
    materials, sections
        By name; members refer to them.
    ground
        The fixed frame with its points.
    links, joints
        By name; the points of a joint are "link.point" or "ground.point".
    masses
        Point masses, by name.
    gravity
        Acceleration along X and Y (m/s^2).
    loads, impulses, springs, dampers
        By name.
    joint_laws
        Friction, stops, clearances, bushings and efforts at joints, by name. Links that bend have none.
    drive
        One drive, or several; none where nothing moves the linkage.
    freedoms
        By joint: what moves by itself, from which state and by which effort. Only method = "transient" has them; those
        that are not stated start at the links' rough angles and at rest.
    effects
        Names of the physical effects that act, or "auto": the program selects those whose influence counts.
    tolerance
        Largest error of a strain relative to its member's largest, or of each of strain, deflection, joint_force and
        torque. With it the program chooses elements, stations and, where no load varies, sub_intervals, whatever is
        stated. It refuses another solver than it takes.
    damping, mesh, analysis
        Damping of the elastic motion, elements of the members, and numerical options.
    measurements
        Measured strains to be drawn beside the computed ones.
    points
        Points whose path is followed beside those of the links, by name.
    study, design
        What a study varies and looks at; which factors of safety and deflections are wanted.
    cases
        Load cases, each with what differs from the scene in it: one run answers all of them.
    petsc
        Options of PETSc and SLEPc.
    plugins
        Keys of effects of other packages, by their names.

    Examples
    --------
    >>> strip = fm.Member(ends=("O", "A"), section="strip", material="steel")
    >>> scene = fm.Scene(
    ...     name="rotating arm",
    ...     materials={"steel": fm.Material(modulus="210 GPa", density=7850)},
    ...     sections={"strip": fm.RectangleSection(width="20 mm", height="3 mm")},
    ...     ground=fm.Ground(points={"O": (0, 0)}),
    ...     links={"arm": fm.Link(points={"O": (0, 0), "A": ("300 mm", 0)}, members={"OA": strip})},
    ...     joints={"O": fm.Revolute(connect=("ground.O", "arm.O"))},
    ...     drive=fm.Drive(joint="O", speed="300 rpm"),
    ... )
    >>> list(scene.members()), round(scene.period, 3)
    (['arm'], 0.2)
    """

    @model_validator(mode="before")
    @classmethod
    def _texts_are_printable(cls, data: Any) -> Any:
        check_texts(data)
        return data

    def _check_keys(self) -> None:
        check_references(self)
        check_cases(self)
