"""Units in which answers are printed: the usual ones of engineers in SI, or those that a user asks for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from fenics_mech.errors import SceneError, shortened
from fenics_mech.scene.unit_spellings import meant
from fenics_mech.scene.units import LONGEST, POUND, in_unit

KINDS = {"strain": "1", "length": "m", "stress": "Pa", "force": "N", "moment": "N*m", "speed": "rad/s"}  # and their SI
MICROSTRAIN = "\N{MICRO SIGN}m/m"
USUAL = dict(zip(KINDS, [(MICROSTRAIN, 1e-6), ("mm", 1e-3), ("MPa", 1e6), ("N", 1.0), ("N m", 1.0), ("rad/s", 1.0)]))
MOST = 20  # units that may be asked for


@dataclass(frozen=True)
class AnswerUnits:
    """The unit of each kind of answer."""

    known: dict[str, tuple[str, float]] = field(default_factory=lambda: dict(USUAL))  # name and size in SI by kind
    stated: frozenset[str] = frozenset()  # kinds whose unit a user asked for, which no prefix changes

    @classmethod
    def of(cls, names: Sequence[str], place: str = "units") -> AnswerUnits:
        """Take units by their names; each is that of the kind of answer that it measures."""
        stated = named_units(names, place)
        return cls(USUAL | stated, frozenset(stated))

    def label(self, kind: str) -> str:
        """Name of the unit of a kind."""
        return self.known[kind][0]

    def size(self, kind: str) -> float:
        """Size of the unit of a kind in SI."""
        return self.known[kind][1]

    def number(self, value: float, kind: str) -> float:
        """Give a value in SI as a number in the unit of its kind."""
        return value / self.known[kind][1]

    def text(self, value: float, kind: str, digits: int = 4) -> str:
        """Write a value in SI as a number with the unit of its kind."""
        return f"{self.number(value, kind):.{digits}g} {self.label(kind)}"


def named_units(names: Sequence[str], place: str = "units") -> dict[str, tuple[str, float]]:
    """Give name and size in SI of each unit that is named, by the kind of answer that it measures."""
    if len(names) > MOST:
        raise SceneError(f"{len(names)} units are too many: an answer has {len(KINDS)}", place=place)
    found = {}
    for name in names:
        if (measured := _kind_of(name)) is None:
            raise SceneError(f"{shortened(name)} is not the unit of a printed answer", place=place, hint=_hint(name))
        found[measured[0]] = name, measured[1]
    return found


def _kind_of(name: str) -> tuple[str, float] | None:
    """Find what a unit measures, and its size in SI; None where it is no unit of an answer."""
    if name in (MICROSTRAIN, "um/m", "microstrain"):
        return "strain", 1e-6
    for kind, unit in KINDS.items() if len(name) < LONGEST - 2 and name.strip() else ():
        try:
            return kind, float(in_unit(unit)(f"1 {name}"))
        except ValueError:
            continue
    return None


def _hint(name: str) -> str:
    """Say what may be meant by a name that is no unit of an answer."""
    words = name.replace(";", " ").split()
    if 1 < len(words) <= MOST and all(_kind_of(word) for word in words):
        return f"Write commas between units: '{', '.join(words)}'"
    if POUND.fullmatch(name):
        return f"{name} is a mass. Write 'lbf' for forces"
    for unit in KINDS.values():
        if len(name) < LONGEST and (likely := meant(f"1 {name}", in_unit(unit))):
            return f"Did you mean '{likely.removeprefix('1 ')}'?"
    return "Known are units of strain, length, stress, force, moment and speed, such as 'mm', 'in', 'psi', 'lbf in'"
