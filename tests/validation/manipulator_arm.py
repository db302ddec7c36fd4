"""A two-link flexible manipulator by hand: shoulder and elbow follow joint angles given as Fourier series.

The dofs are those of the upper arm's inner nodes, the elbow's translations X, Y and its one rotation (the motor holds
the angle between the arms), and those of the forearm's other nodes up to the free tip.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from tests.validation.reference.nine_element import LinkMotion
from tests.validation.two_links import Ending, TwoLinkModel, TwoLinkParameters, as_angles, link_motions

Series = tuple[float, tuple[float, ...], tuple[float, ...]]
"""Mean (rad), and the factors of cos(n phase) and sin(n phase), n = 1, 2, ..."""


@dataclass(frozen=True)
class ManipulatorParameters(TwoLinkParameters):
    """Upper arm and forearm, and the angles of the shoulder and of the elbow against the upper arm."""

    shoulder: Series = (0.0, (), ())
    elbow: Series = (0.0, (), ())


class ManipulatorModel(TwoLinkModel):
    """The manipulator as beam elements.

    Parameters
    ----------
    parameters
        The manipulator.
    elements
        Elements per arm.
    """

    parameters: ManipulatorParameters

    def __init__(self, parameters: ManipulatorParameters, elements: int = 3) -> None:
        super().__init__(parameters, elements)

    def motion(self, theta: ArrayLike) -> tuple[LinkMotion, LinkMotion]:
        """Rigid-body motion of both arms at phases `theta` = 2 pi t/period (rad)."""
        p, phase = self.parameters, as_angles(theta)
        waves = np.zeros((3, 2, len(phase)))  # derivative in time, joint, angle
        for joint, (mean, cosine, sine) in enumerate((p.shoulder, p.elbow)):
            waves[0, joint] += mean
            for factors, unit in ((cosine, 1.0), (sine, -1j)):
                for n, factor in enumerate(factors, 1):
                    wave = factor * unit * np.exp(1j * n * phase)
                    for order in range(3):
                        waves[order, joint] += ((1j * n * p.omega1) ** order * wave).real
        angle, omega, alpha = np.cumsum(waves, axis=1).swapaxes(1, 2)
        return link_motions(angle, omega, alpha, p.lengths[0])

    def layout(self) -> tuple[list[str], list[list[str]], list[list[Ending]]]:
        """See `TwoLinkModel.layout`."""
        upper, fore = self.inner(1), [*self.inner(2), "tip u", "tip w", "tip phi"]
        names = [*upper, "X", "Y", "phi", *fore]
        rows = [["", "", "", *upper, "", "", "phi"], ["", "", "phi", *fore]]
        pin = (names.index("X"), names.index("Y"))
        return names, rows, [[Ending(3 * self.elements, pin, np.eye(2))], [Ending(0, pin, np.eye(2))]]
