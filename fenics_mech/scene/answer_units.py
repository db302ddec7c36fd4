"""Units in which answers are printed: the usual ones of engineers in SI, or those that a user asks for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from fenics_mech.errors import SceneError, shortened
from fenics_mech.scene.units import QUANTITY, in_unit

KINDS = {"strain": "1", "length": "m", "stress": "Pa", "force": "N", "moment": "N*m", "speed": "rad/s"}  # and their SI
MICROSTRAIN = "\N{MICRO SIGN}m/m"
USUAL = {
    "strain": (MICROSTRAIN, 1e-6),
    "length": ("mm", 1e-3),
    "stress": ("MPa", 1e6),
    "force": ("N", 1.0),
    "moment": ("N m", 1.0),
    "speed": ("rad/s", 1.0),
}
MOST = 20  # units that may be asked for


@dataclass(frozen=True)
class AnswerUnits:
    """The unit of each kind of answer.

    Parameters
    ----------
    known
        Name of the unit and its size in SI, by kind; see `KINDS`.
    """

    known: dict[str, tuple[str, float]] = field(default_factory=lambda: dict(USUAL))

    @classmethod
    def of(cls, names: Sequence[str], place: str = "units") -> AnswerUnits:
        """Take units by their names; each is that of the kind of answer that it measures.

        Parameters
        ----------
        names
            Names of units, such as "in", "psi", "lbf", "lbf in", "rpm", "%".
        place
            Where they are stated, for the error.

        Raises
        ------
        SceneError
            When a name is no unit of an answer.

        Examples
        --------
        >>> from fenics_mech.scene.answer_units import AnswerUnits
        >>> round(AnswerUnits.of(["in"]).number(0.0127, "length"), 3)
        0.5
        """
        if len(names) > MOST:
            raise SceneError(f"{len(names)} units are too many: an answer has {len(KINDS)}", place=place)
        known = dict(USUAL)
        for name in names:
            kind, size = _kind_of(name, place)
            known[kind] = (name, size)
        return cls(known)

    def label(self, kind: str) -> str:
        """Name of the unit of a kind.

        Parameters
        ----------
        kind
            The kind, one of `KINDS`.
        """
        return self.known[kind][0]

    def size(self, kind: str) -> float:
        """Size of the unit of a kind in SI.

        Parameters
        ----------
        kind
            The kind, one of `KINDS`.
        """
        return self.known[kind][1]

    def number(self, value: float, kind: str) -> float:
        """Give a value in SI as a number in the unit of its kind.

        Parameters
        ----------
        value
            The value in SI.
        kind
            The kind, one of `KINDS`.
        """
        return value / self.known[kind][1]


def _kind_of(name: str, place: str) -> tuple[str, float]:
    """Find what a unit measures, and its size in SI."""
    if name in (MICROSTRAIN, "um/m", "microstrain"):
        return "strain", 1e-6
    for kind, unit in KINDS.items() if len(name) < QUANTITY.longest - 2 and name.strip() else ():
        try:
            return kind, float(in_unit(unit)(f"1 {name}"))
        except ValueError:
            continue
    raise SceneError(
        f"{shortened(name)} is not the unit of a printed answer",
        place=place,
        hint="Known are units of strain, length, stress, force, moment and speed, such as 'mm', 'in', 'psi', 'lbf in'",
    )
