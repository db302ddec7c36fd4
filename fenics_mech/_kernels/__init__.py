"""Compiled loops over instants and elements: measures of two poses and their derivatives, forces, tangents, inertia."""

from __future__ import annotations

from typing import Any

import numpy as np

from fenics_mech._kernels import _compiled  # type: ignore[attr-defined]

KINDS = {np.dtype(np.float64): "double[]", np.dtype(np.int32): "int[]"}


def call(name: str, *arguments: Any) -> None:
    """Call a loop; arrays have to be contiguous, of doubles or of 32-bit integers, and None is no array."""
    given = [_compiled.ffi.from_buffer(KINDS[x.dtype], x) if isinstance(x, np.ndarray) else x for x in arguments]
    getattr(_compiled.lib, name)(*[_compiled.ffi.NULL if x is None else x for x in given])
