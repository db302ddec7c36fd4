"""Forces of a few modes beside sparse matrices: the factors of the modes' own equations in each step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._sparse.kernels import LANES, pointer


@dataclass(frozen=True, eq=False)
class FewModes:
    """Forces ``F^T y`` of the rates ``y = G q' + H q`` of a few modes, as `kernels.c` takes them.

    A step's matrix B has the full matrix ``U V`` beside it, which these forces make. It is not formed: only the inverse
    of ``1 + V B^-1 U`` is (the formula of Sherman, Morrison and Woodbury).

    Parameters
    ----------
    module
        The compiled loops.
    arrays
        F, G and H, ``(points, modes, size)``, and the inverse matrices ``(steps, stages modes, stages modes)``.
    record
        The same as C reads it.
    """

    module: Any
    arrays: tuple[Array, ...]
    record: Any

    @classmethod
    def of(cls, module: Any, outward: Array, by_rate: Array, by_place: Array, steps: int) -> FewModes:
        """Take F, G and H at the points of so many steps."""
        count = outward.shape[1]
        numbers = len(outward) // steps * count
        given = (np.ascontiguousarray(part) for part in (outward, by_rate, by_place))
        arrays = (*given, np.empty((steps, numbers, numbers)))
        record = module.ffi.new("modal *")
        record.count = count
        for name, array in zip(("outward", "by_rate", "by_place", "inverse"), arrays):
            setattr(record, name, pointer(module, array))
        return cls(module, arrays, record)

    @property
    def count(self) -> int:
        """Number of modes."""
        return self.arrays[0].shape[1]

    def factorise(self, layout: Any, duration: Array, inner: Array, square: Array, factors: Array) -> int:
        """Make the inverse matrices with the factors of the steps; give the first singular step, or -1."""
        stages, size = len(inner), self.arrays[0].shape[2]
        numbers = stages * self.count
        work = np.empty((stages + 2) * size * LANES + numbers * (numbers + 2 * LANES))
        parts = duration, inner, square, factors, work
        given = (pointer(self.module, part) for part in parts)
        return int(self.module.lib.factor_modal(layout, self.record, len(duration), *given))
