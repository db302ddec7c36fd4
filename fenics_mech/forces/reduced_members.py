"""What happens inside members that are reduced: by statics, from what acts on them."""

from __future__ import annotations

import numpy as np

from fenics_mech._arrays import Array, each
from fenics_mech.beams.element_dofs import element_dofs, member_rotation
from fenics_mech.beams.element_matrices import Beams
from fenics_mech.beams.span import Span, outside


def response_of_reduced_members(beams: Beams, strained: Array, missing: Array) -> tuple[Array, Array]:
    """Balance the inner nodes of reduced members: the modes left out answer statically (mode acceleration).

    Source: Cornwell, Craig and Johnson, Earthq. Eng. Struct. Dyn. 11 (1983) 679.

    Parameters
    ----------
    beams
        The links.
    strained
        Displacement whose elastic forces are all stress of the links, ``(angles, nodal dofs)``.
    missing
        Force that the nodes need from the links' stress, in link axes, ``(angles, nodal dofs)``.

    Returns
    -------
    tuple
        Elastic forces on the elements' ends in member axes, ``(angles, elements, 6)``, and the displacement that they
        go with, ``(angles, nodal dofs)``.
    """
    assert beams.reduction is not None
    mesh, spans = beams.mesh, beams.reduction.spans
    settled, elastic = strained.copy(), np.zeros((len(strained), len(mesh.cell), 6))
    whole = outside(mesh, spans)
    if whole.any():
        v = each(member_rotation(mesh)[whole], strained[:, element_dofs(mesh)[whole]])
        elastic[:, whole] = each(beams.element_stiffness[whole], v)
    for span in spans:
        elastic[:, span.cells], settled[:, span.inner] = _of_span(span, strained, missing)
    return elastic, settled


def _of_span(span: Span, strained: Array, missing: Array) -> tuple[Array, Array]:
    """Elastic forces on the ends of a member's elements, and the displacement of its inner nodes in link axes."""
    ends = strained[:, span.ends.reshape(2, 3)] @ span.rotation.T
    moved, forces = span.chain.carried(ends.reshape(-1, 6))
    bent, more = span.chain.clamped(-missing[:, span.inner] @ span.rotation.T)
    second = forces + more
    first = -second
    first[..., 2] -= span.chain.length * second[..., 1]
    return np.concatenate([first, second], axis=-1), (moved + bent) @ span.rotation
