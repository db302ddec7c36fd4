"""The place at which the strains of a sweep are split into harmonics."""

from __future__ import annotations

from dataclasses import dataclass

from fenics_mech.errors import MechanismError


@dataclass(frozen=True)
class Gauge:
    """The place whose strain is split into harmonics.

    Parameters
    ----------
    s
        Place along every member, 0..1.
    fibre
        "+" or "-".
    harmonics
        Number of harmonics kept, beside the mean.

    Examples
    --------
    >>> fm.Gauge(s=0.3, fibre="-").harmonics
    20
    """

    s: float = 0.5
    fibre: str = "+"
    harmonics: int = 20

    def __post_init__(self) -> None:
        if not (0 <= self.s <= 1 and self.fibre in ("+", "-") and self.harmonics >= 1):
            raise MechanismError(f"a gauge needs s from 0 to 1, fibre + or -, and 1 harmonic or more; found {self}")
