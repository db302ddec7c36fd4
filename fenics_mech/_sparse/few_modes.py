"""Forces of a few modes beside sparse matrices: the factors of the modes' own equations in each step."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from fenics_mech._arrays import Array
from fenics_mech._sparse.kernels import LANES, pointer


@dataclass(frozen=True, eq=False)
class FewModes:
    """Forces ``Z^T F^T y`` of the rates ``y = G Z q' + H Z q`` of a few modes, as `kernels.c` takes them.

    A step's matrix B has the full matrix ``U V`` beside it, which these forces make. It is not formed: only the inverse
    of ``1 + V B^-1 U`` is (the formula of Sherman, Morrison and Woodbury).

    Parameters
    ----------
    module
        The compiled loops.
    arrays
        F, G and H, ``(points, modes, seen)``, the inverse matrices ``(steps, stages modes, stages modes)``, and Z.
    record
        The same as C reads it.
    """

    module: Any
    arrays: tuple[NDArray[Any], ...]
    record: Any

    @classmethod
    def of(cls, module: Any, parts: tuple[Array, Array, Array], steps: int, seen: sp.csr_matrix | None) -> FewModes:
        """Take F, G and H at the points of so many steps, and Z: without it the modes see the coordinates."""
        count = parts[0].shape[1]
        numbers = len(parts[0]) // steps * count
        arrays: dict[str, NDArray[Any]] = dict(
            zip(("outward", "by_rate", "by_place"), map(np.ascontiguousarray, parts))
        )
        arrays["inverse"] = np.empty((steps, numbers, numbers))
        if seen is not None:
            back = seen.tocsc()
            arrays |= {"begin": seen.indptr, "columns": seen.indices, "shares": seen.data}
            arrays |= {"back": back.indptr, "rows": back.indices, "back_shares": back.data}
        record = module.ffi.new("modal *")
        record.count, record.seen = count, parts[0].shape[2]
        for name, array in arrays.items():
            setattr(record, name, pointer(module, array))
        return cls(module, tuple(arrays.values()), record)

    @property
    def count(self) -> int:
        """Number of modes."""
        return self.arrays[0].shape[1]

    @property
    def seen(self) -> int:
        """Number of what they see of the coordinates."""
        return self.arrays[0].shape[2]

    def factorise(self, layout: Any, duration: Array, inner: Array, square: Array, factors: Array) -> int:
        """Make the inverse matrices with the factors of the steps; give the first singular step, or -1."""
        stages = len(inner)
        numbers = stages * self.count
        work = np.empty((stages * layout.size + (stages + 2) * self.seen) * LANES + numbers * (numbers + 2 * LANES))
        parts = duration, inner, square, factors, work
        given = (pointer(self.module, part) for part in parts)
        return int(self.module.lib.factor_modal(layout, self.record, len(duration), *given))
