"""Compiled loops over instants and elements: measures of two poses and their derivatives, forces, tangents, inertia."""

from __future__ import annotations

from typing import Any

import numpy as np

from fenics_mech._kernels.sources import fingerprint

REMEDY = "Run `python fenics_mech/_kernels/build.py`, or install fenics_mech again"
try:
    from fenics_mech._kernels import _compiled  # type: ignore[attr-defined]
except ImportError as error:
    raise ImportError(f"the kernels of fenics_mech are not compiled, or cannot be loaded: {error}. {REMEDY}") from error
built_from = getattr(_compiled.lib, "built_from", None)  # libraries of old do not say it
if built_from is None or _compiled.ffi.string(built_from()).decode() != fingerprint():
    raise ImportError(f"the compiled kernels of fenics_mech are of other sources than those beside them. {REMEDY}")

KINDS = {np.dtype(np.float64): "double[]", np.dtype(np.int32): "int[]"}


def call(name: str, *arguments: Any) -> Any:
    """Call a loop, and give its value; arrays are contiguous, of doubles or 32-bit integers, and None is no array."""
    ffi = _compiled.ffi
    given = [
        ffi.NULL if x is None else ffi.from_buffer(KINDS[x.dtype], x) if isinstance(x, np.ndarray) else x
        for x in arguments
    ]
    return getattr(_compiled.lib, name)(*given)
