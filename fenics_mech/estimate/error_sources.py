"""Errors of strains, deflections, joint forces and efforts of drives, one by each source.

They come from motions that are found without most of that error.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import UnresolvedError
from fenics_mech.estimate.accepted_errors import ACCEPTED, refusal_by
from fenics_mech.estimate.missed_peaks import MissedPeaks
from fenics_mech.estimate.quantities import measures, places_of
from fenics_mech.scene import Scene

STEPS = ("time", "harmonics")
BY_POSITIONS = 2.0  # with which power of their number errors by peaks between positions fall
NUMERICAL = (*STEPS, "modes", "mesh")  # sources that are judged
JUDGED = (
    ("strain", STEPS, ACCEPTED.by_steps),
    ("strain", NUMERICAL, ACCEPTED.of_strain),
    ("deflection", NUMERICAL, ACCEPTED.of_rest),
    ("joint_force", NUMERICAL, ACCEPTED.of_rest),
)
PLACES = {  # of an error, in words, and what it is relative to
    "strain": ("strain of", "its largest value"),
    "deflection": ("deflection of", "its largest value"),
    "joint_force": ("force in joint", "the largest joint force"),
    "torque": ("effort of the drive at", "the largest effort of a drive"),
}


@dataclass(frozen=True)
class Errors:
    """Errors by their sources."""

    # These are "time" (steps), "mesh", "modes" (left out), "harmonics", "stations", "theory", "effects" and "joints".
    # Quantities are "strain", "deflection", "joint_force" and "torque", see `places_of`.

    # by quantity, then by source: of each member's strain (1) and deflection (m), of the force in each joint (N) and
    # of the effort of each drive (N m or N), ``(members, joints or drives,)``
    errors: Mapping[str, dict[str, Array]]
    # with which power of its number a source falls: of sub-intervals, elements, modes, harmonics, stations; 0 where
    # it does not
    order: dict[str, float]
    measure: Mapping[str, Array]  # by quantity, what errors are relative to; see `measures`
    remarks: tuple[str, ...] = ()  # what is wrong by more than the estimates say
    largest: Mapping[str, Array] = field(default_factory=dict)  # by quantity, the largest values
    missed: MissedPeaks | None = None  # what lies between the positions of a cycle

    def relative(self, what: str) -> dict[str, float]:
        """Largest error of a quantity by each source, relative to its measure."""
        size = self.measure[what]
        return {source: float((error / size).max(initial=0.0)) for source, error in self.errors[what].items()}

    def total(self, what: str) -> float:
        """Largest error of a quantity by all sources together, relative to its measure."""
        return float(self.of(list(self.errors[what]), what).max(initial=0.0))

    def judge(self, scene: Scene) -> None:
        """Raise `UnresolvedError` where the numerical errors are too large, unless the scene lets them pass."""
        # Strains are what a mesh and steps are chosen for. Deflections and joint forces are refused only where they
        # have not one right digit. Efforts of drives of a balanced mechanism are small differences, and are told.
        if not scene.analysis.allow_coarse and (refusal := self.refusal(scene)) is not None:
            raise refusal

    def refusal(self, scene: Scene) -> UnresolvedError | None:
        """Give the error that says where numerical errors are too large, and by what; None where they are not."""
        enough = self._enough(scene)
        if enough is None:  # then no steps cure it
            return self.missing(scene)
        names = places_of(scene.members(), scene.joints, scene.moved_joints)
        for what, sources, limit in JUDGED:
            errors = self.of(sources, what)
            if not errors.max(initial=0.0) <= limit:
                worst = int(errors.argmax())
                shares = {source: float(self.of([source], what)[worst]) for source in sources}
                place, measure = PLACES[what]
                said = f"{place} {names[what][worst]!r} is uncertain by"
                return refusal_by(scene, said, measure, shares, self.order, limit, enough or 0)
        return self.missing(scene)

    def refuse_missed(self, scene: Scene) -> None:
        """Raise `UnresolvedError` where the positions surely miss peaks of joint forces or strains by too much."""
        if (refusal := self.missing(scene)) is not None:
            raise refusal

    def missing(self, scene: Scene) -> UnresolvedError | None:
        """Give the error that says which peaks the positions surely miss by too much; None where they miss none."""
        names = places_of(scene.members(), scene.joints, scene.moved_joints)
        for what, missed in self._missed().items():
            if self.missed is not None and missed.max(initial=0.0) > ACCEPTED.by_positions:
                worst = int(missed.argmax())
                where = f"{PLACES[what][0]} {names[what][worst]!r}"
                return self.missed.refusal((what, worst), where, self._enough(scene))
        return None

    def _missed(self) -> dict[str, Array]:
        """Share of their measure by which positions surely miss peaks, of joint forces first, which have them too."""
        if self.missed is None:
            return {}
        known = self.missed.known
        return {what: known[what] / self.measure[what] for what in ("joint_force", "strain") if what in known}

    def _enough(self, scene: Scene) -> int | None:
        """Number of positions that surely miss no peak by too much: 0 where these do not, None where too many."""
        missed = self._missed()
        if self.missed is None or not any(
            shares.max(initial=0.0) > ACCEPTED.by_positions for shares in missed.values()
        ):
            return 0
        most = ACCEPTED.by_positions / ACCEPTED.margin
        measure = measures(scene, {**self.largest, **self.missed.peaks})  # as it is where the peaks are shown
        return self.missed.enough({what: most * measure[what] for what in missed})

    def of(self, sources: Sequence[str], what: str = "strain") -> Array:
        """Error of a quantity by some sources together, relative to its measure, ``(members, joints or drives,)``."""
        found = [self.errors[what][source] for source in sources if source in self.errors[what]]
        return np.sum(found, axis=0) / self.measure[what] if found else np.zeros_like(self.measure[what])

    def of_power(self, rates: Array) -> float:
        """Give what the errors of efforts make of the mean power of drives with rates ``(angles, drives)`` (W)."""
        uncertain = np.sum(list(self.errors["torque"].values()), axis=0)[: rates.shape[1]]
        return float(uncertain @ np.abs(rates).mean(axis=0))

    @property
    def too_large(self) -> bool:
        """Whether they are larger than `judge` lets pass."""
        if any(shares.max(initial=0.0) > ACCEPTED.by_positions for shares in self._missed().values()):
            return True
        judged_here = [one for one in JUDGED if one[0] in self.errors]
        return any(not self.of(sources, what).max(initial=0.0) <= limit for what, sources, limit in judged_here)
