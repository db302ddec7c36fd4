"""The four-bar of Kaminski (1989), section 7.1, as one frozen set of numbers in SI units."""

from __future__ import annotations

from dataclasses import dataclass

Triple = tuple[float, float, float]
"""One number for each of crank, coupler and follower, in that order."""


@dataclass(frozen=True)
class FourBarParameters:
    """A planar four-bar with straight uniform links, driven at constant crank speed.

    The default lengths are the inches behind Table 7.1 (4.25, 11, 10.65 and 10), not its rounded centimetres:
    only with them does chapter 6 give back the numbers printed in Appendix G.

    Parameters
    ----------
    a, b, c
        Length of crank OA, coupler AB and follower CB (m).
    L
        Distance OC between the ground pivots (m).
    omega1
        Angular speed of the crank (rad/s).
    rho
        Mass density of the links (kg/m^3).
    E
        Young's modulus of the links (Pa).
    area
        Cross-section areas (m^2).
    inertia
        Second moments of area about the bending axis (m^4).
    fibre
        Distances from the neutral axis to the outer fibre (m).
    mass_A, mass_B
        Masses lumped at the joints A and B (kg).
    """

    a: float = 0.10795
    b: float = 0.2794
    c: float = 0.27051
    L: float = 0.254
    omega1: float = 32.3
    rho: float = 2714.0
    E: float = 7.1e10
    area: Triple = (1.07e-4, 4.06e-5, 4.06e-5)
    inertia: Triple = (1.62e-10, 8.67e-12, 8.67e-12)
    fibre: Triple = (2.12e-3, 8.0e-4, 8.0e-4)
    mass_A: float = 0.0452  # noqa: N815 - the joints are called A and B
    mass_B: float = 0.03755  # noqa: N815

    @property
    def lengths(self) -> Triple:
        """Lengths of crank, coupler and follower (m)."""
        return self.a, self.b, self.c

    @property
    def masses(self) -> Triple:
        """Masses m1, m2, m3 of crank, coupler and follower (kg)."""
        m1, m2, m3 = (self.rho * area * length for area, length in zip(self.area, self.lengths, strict=True))
        return m1, m2, m3
