"""What is found of one way in which a member may fail."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

from fenics_mech.scene import Design

Kind = Literal["stress", "force", "moment", "length", "share"]
WANTED = {  # factors of safety by the key of `[design] safety`, and the distance from a critical speed
    "yield": 1.5,  # ductile metals whose loads and strength are known (Shigley's, section 1-10; Juvinall, 1.5 to 2)
    "buckling": 3.0,  # straight pinned struts of machines; imperfections are not computed
    "fatigue": 1.5,
    "pin": 2.0,
    "resonance": 0.1,
}
KEYS = {  # of `WANTED`, by mode
    "yield": "yield",
    "buckling in plane": "buckling",
    "buckling across": "buckling",
    "lateral torsion": "buckling",
    "fatigue": "fatigue",
    "pin and eye": "pin",
    "deflection": "deflection",
    "resonance": "resonance",
}
NOTHING = 1e-9  # of what is borne, up to which what acts is rounding


@dataclass(frozen=True)
class Check:
    """One mode of failure of one member.

    Parameters
    ----------
    mode
        Its name, one of `KEYS`.
    acting, borne
        The largest that acts and what is borne at most, in SI.
    kind
        What these are.
    wanted
        The wanted factor of safety.
    theta
        Drive angle (rad) of the largest; None where there is none.
    detail
        What of it is weakest, such as "net section".
    rests_on
        Assumptions that keep it from deciding: of a grade, a pin, or a limit of the deflection.
    assumed
        Other assumptions.
    missing
        What the scene would have to say; then nothing else is known.
    case
        The load case in which that is; "" where the scene has none.
    """

    mode: str
    acting: float
    borne: float
    kind: Kind
    wanted: float
    theta: float | None = None
    detail: str = ""
    rests_on: tuple[str, ...] = ()
    assumed: tuple[str, ...] = ()
    missing: str = ""
    case: str = ""

    @property
    def factor(self) -> float:
        """Factor of safety; infinite where nothing acts, NaN where it is not known."""
        if self.missing:
            return math.nan
        return math.inf if self.acting <= NOTHING * self.borne else self.borne / self.acting

    @property
    def share(self) -> float:
        """Factor of safety over the wanted one: below 1 it is too small."""
        return self.factor / self.wanted

    @property
    def known(self) -> bool:
        """Whether it was judged."""
        return not self.missing

    @property
    def decides(self) -> bool:
        """Whether it was judged by what the scene says."""
        return self.known and not self.rests_on

    def also_assumed(self, *texts: str) -> Check:
        """Give it with further assumptions.

        Parameters
        ----------
        texts
            The assumptions; empty ones are left out.
        """
        return replace(self, assumed=(*self.assumed, *filter(None, texts)))


def unknown(mode: str, missing: str) -> Check:
    """Give a mode that is not judged."""
    return Check(mode, 0.0, 1.0, "share", 1.0, missing=missing)


def wanted(design: Design, mode: str) -> float:
    """Give the wanted factor of safety of a mode."""
    key = KEYS[mode]
    stated = {str(name): size for name, size in design.safety.items()}
    return float((WANTED | stated).get(key, 1.0))
