"""Timoshenko's beam: sections have rotary inertia, and do not stay normal to the axis."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from fenics_mech._arrays import Array
from fenics_mech.beams.distributions import along_elements
from fenics_mech.beams.shapes import NORMAL
from fenics_mech.errors import SceneError
from fenics_mech.scene import Scene
from fenics_mech.scene.joints import Joint

if TYPE_CHECKING:
    from fenics_mech.beams.element_matrices import Beams


def sheared(scene: Scene, links: Beams) -> Beams:
    """Add the stiffness of shear, with an angle of shear gamma in each element that its equilibrium gives."""
    # The axis w is cubic, its slope at a node gamma more than the rotation phi of the section there. Gamma, constant
    # in the element, makes its energy of bending and shear stationary. So the element is exact under forces at its
    # ends, however thin it is: nothing locks.
    refuse_travelling(scene.joints)
    (stiffness,) = along_elements(
        links.layout, lambda label, s: scene.shear_stiffness(label, s)[None], links.rigidity.varies
    )
    angle = _angle(links, stiffness.mean * links.mesh.cell_length)
    return replace(links, layout=links.layout.sheared(angle), rigidity=replace(links.rigidity, shear=stiffness))


def _angle(links: Beams, stiffness: Array) -> Array:
    """Angle of shear by w and phi of both nodes, ``(elements, 4)``; `stiffness` is the integral of G A_s (N m)."""
    from fenics_mech import _fenicsx  # noqa: PLC0415  (dolfinx is slow to import, and few scenes have shear)
    from fenics_mech.beams.forms import bending  # noqa: PLC0415

    layout = links.layout
    broken = _fenicsx.assemble_matrix(bending(layout.space, links.rigidity.bending.coefficient))
    moments = layout.of_elements(broken)[:, NORMAL][..., [2, 5]].sum(axis=-1)  # of both ends, by w and w'
    return -moments / (moments[:, [1, 3]].sum(axis=-1) + stiffness)[:, None]


def refuse_travelling(joints: Mapping[str, Joint]) -> None:
    """Raise `SceneError` where the pin of a joint travels along a member."""
    for name, joint in joints.items():
        if joint.member is not None:
            raise SceneError(
                "the effect 'shear' is not available where pins travel along members",
                place=f"joints.{name}.member",
                hint="Leave 'shear' out of the effects",
            )


def with_rotary_inertia(scene: Scene, links: Beams) -> Beams:
    """Add ``int rho I phi psi dx`` to the mass, phi the rotation of the sections."""
    # A section turns by the rigid angle of its link and by phi, with the kinetic energy rho I (omega + phi')^2/2 per
    # length. So the mass also acts on the link's angular acceleration, the slope of the rigid acceleration. It has no
    # part in the gyroscopic matrix, and none in the centrifugal forces.
    (rotary,) = along_elements(
        links.layout, lambda label, s: scene.rigidity(label, s).rotary_inertia[None], links.rigidity.varies
    )
    return replace(links, inertia=replace(links.inertia, rotary=rotary))
