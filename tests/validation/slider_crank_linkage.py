"""A slider-crank with elastic crank and rod, by hand: crank OA at constant speed, rod AB, slider B on a level guide.

The dofs are those of the crank's inner nodes, the pin A's translations X, Y and the two rotations there, those of the
rod's inner nodes, the slide of B along the guide and the rod's rotation at B.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tests.validation.reference.nine_element import LinkMotion
from tests.validation.two_links import Ending, TwoLinkModel, TwoLinkParameters, as_angles, link_motions


@dataclass(frozen=True)
class SliderCrankParameters(TwoLinkParameters):
    """Crank and rod, the guide's offset above O (m) and the slider's mass as that at the end of the rod."""

    offset: float = 0.0


class SliderCrankModel(TwoLinkModel):
    """The slider-crank as beam elements.

    Parameters
    ----------
    parameters
        The slider-crank.
    elements
        Elements per link.
    """

    parameters: SliderCrankParameters

    def __init__(self, parameters: SliderCrankParameters, elements: int = 3) -> None:
        super().__init__(parameters, elements)

    def motion(self, theta: ArrayLike) -> tuple[LinkMotion, LinkMotion]:
        """Rigid-body motion of crank and rod at crank angles `theta` (rad), with the slider on the right."""
        p, crank = self.parameters, as_angles(theta)
        (r, rod), speed = p.lengths, p.omega1
        lean = np.arcsin((p.offset - r * np.sin(crank)) / rod)  # r sin(theta) + l sin(lean) = e
        rate = -r * speed * np.cos(crank) / (rod * np.cos(lean))
        second = (r * speed**2 * np.sin(crank) + rod * rate**2 * np.sin(lean)) / (rod * np.cos(lean))
        zero = np.zeros_like(crank)
        angle, omega, alpha = np.stack([[crank, lean], [zero + speed, rate], [zero, second]]).swapaxes(1, 2)
        return link_motions(angle, omega, alpha, r)

    def layout(self) -> tuple[list[str], list[list[str]], list[list[Ending]]]:
        """See `TwoLinkModel.layout`."""
        crank, rod = self.inner(1), self.inner(2)
        names = [*crank, "X", "Y", "phi1", "phi2", *rod, "slide", "phi3"]
        rows = [["", "", "", *crank, "", "", "phi1"], ["", "", "phi2", *rod, "", "", "phi3"]]
        pin, last = (names.index("X"), names.index("Y")), 3 * self.elements
        slide = Ending(last, (names.index("slide"),), np.array([[1.0], [0.0]]))
        return names, rows, [[Ending(last, pin, np.eye(2))], [Ending(0, pin, np.eye(2)), slide]]
