"""How much of natural frequencies shear flexibility and rotary inertia of the beams change, mode by mode.

By Rayleigh's quotient ``2 d omega/omega`` is ``-int Q^2/(G A_s) ds/omega^2`` for shear and ``-int rho I phi^2 ds`` for
rotary inertia, of a mode with unit modal mass. Q is what the stiffness of an element gives, so that a heavy mass at the
end of a short beam counts too.

Source: Timoshenko, Vibration Problems in Engineering, section 5.12; Rayleigh, The Theory of Sound, section 162.
"""

from __future__ import annotations

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.beams.distributions import along_elements
from fenics_mech.beams.element_dofs import in_member_axes
from fenics_mech.beams.element_matrices import Beams
from fenics_mech.effects.known import SHEAR
from fenics_mech.errors import SceneError
from fenics_mech.scene import Scene

STEEL = 3.1  # E A/(G A_s) of a rectangle of steel, 2 (1 + 0.3) 6/5: for members that do not state what shear needs


def frequency_shares(scene: Scene, beams: Beams, omega: Array, shapes: Array) -> dict[str, Array]:
    """Give the shares of each frequency that shear and rotary inertia take off, ``(modes,)`` each."""
    # omega, shapes: frequencies at some positions ``(positions, modes)`` (rad/s), and displacements of the nodes in
    # the axes of their links, of unit modal mass ``(positions, modes, nodes, 3)``
    h = beams.mesh.cell_length
    turning = along_elements(
        beams.layout, lambda label, s: scene.rigidity(label, s).rotary_inertia[None], beams.rigidity.varies
    )
    per_force, per_turn = h / _shear_stiffness(scene, beams), turning[0].mean * h / 3  # of rho I (kg m)
    shares = np.zeros((2, omega.shape[1]))
    for here, moved in zip(omega, shapes):
        v = in_member_axes(beams.mesh, moved.reshape(len(moved), -1))
        across = np.einsum("ej,mej->me", beams.element_stiffness[:, 1], v)
        first, second = v[..., 2], v[..., 5]
        square = np.square(here)
        shares[0] += np.divide(across**2 @ per_force, 2 * square, out=np.zeros_like(square), where=square > 0)
        shares[1] += (first**2 + first * second + second**2) @ per_turn / 2 * (square > 0)
    return dict(zip((SHEAR, "rotary-inertia"), shares / len(omega)))


def _shear_stiffness(scene: Scene, beams: Beams) -> Array:
    """G A_s of each element (N); that of steel where it is not stated."""

    def of_member(label: str, s: Array) -> Array:
        try:
            return scene.shear_stiffness(label, s)[None]
        except SceneError:
            return scene.rigidity(label, s).axial[None] / STEEL

    return along_elements(beams.layout, of_member, beams.rigidity.varies)[0].mean
