"""The last motions of a run, such as over a speed, from which Newton's method begins the next one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Generic, Protocol, TypeVar


class Continuable(Protocol):
    """A motion that a straight line continues."""

    def beyond(self, before: Any, share: float) -> Any:
        """Go on as from another motion to this one, by a share of the difference."""


Motion = TypeVar("Motion", bound=Continuable)
FARTHEST = 1.5  # share of the way between two motions, by which the next is sought beyond them


class LastMotions(Generic[Motion]):
    """The last two motions of a run, and where in it they are."""

    def __init__(self) -> None:
        self._place = 0.0
        self._motions: list[tuple[float, Motion]] = []

    def go_to(self, place: float | None) -> None:
        """Go to the next motion."""
        if place is None:
            self._motions = []
        self._place = place or 0.0

    def keep(self, motion: Motion) -> None:
        """Keep the motion at the place."""
        self._motions = [*self._motions[-1:], (self._place, motion)]

    def near(self, fits: Callable[[Motion], bool]) -> Motion | None:
        """Give a motion from which to begin: beyond the last ones that fit, on a straight line."""
        known = [(place, motion) for place, motion in self._motions if fits(motion)]
        if not known:
            return None
        (before, first), (last, motion) = known[0], known[-1]
        share = (self._place - last) / (last - before) if last != before else 0.0
        found: Motion = motion.beyond(first, share) if 0 < share <= FARTHEST else motion
        return found

    @property
    def found(self) -> Motion | None:
        """The motion at the place, where it was kept."""
        return next((motion for place, motion in self._motions[-1:] if place == self._place), None)
