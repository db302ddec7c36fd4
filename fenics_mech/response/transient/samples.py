"""Times at which a motion is given, as its steps come to them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._progress import reached
from fenics_mech.response.transient.course import TRANSIENT


@dataclass
class Samples:
    """The times, and how many of them are known.

    Parameters
    ----------
    times
        Ascending (s), ``(times,)``.
    known
        Number of those at which the motion is known.
    """

    times: Array
    known: int = 0

    @property
    def _rounding(self) -> float:
        """By how much the end of a step may be beside a time (s)."""
        return float(TRANSIENT.rounding * self.times[-1])

    def taken(self, end: float) -> slice:
        """Give those up to the end of a step that were not known yet, and know them from here on.

        Parameters
        ----------
        end
            End of the step (s).
        """
        reached(end, float(self.times[0]), float(self.times[-1]))
        before, self.known = self.known, int(np.searchsorted(self.times, end + self._rounding))
        self.known = max(before, self.known)
        return slice(before, self.known)

    def forget(self, time: float) -> bool:
        """Forget the last one where it is at a time at which an impulse strikes; say whether it is: it is taken after.

        Parameters
        ----------
        time
            When (s).
        """
        found = self.known > 0 and bool(self.times[self.known - 1] >= time - self._rounding)
        self.known -= int(found)
        return found
