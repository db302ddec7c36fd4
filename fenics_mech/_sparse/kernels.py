"""The compiled loops of `kernels.c`, for steps of so many stages."""

from __future__ import annotations

import hashlib
import importlib.util
import shutil
import sys
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from cffi import FFI  # type: ignore[import-untyped]
from numpy.typing import NDArray

from fenics_mech._compiling import compile_safely

SOURCE, MARCH = (Path(__file__).with_name(name) for name in ("kernels.c", "march.h"))
LANES = 4  # right-hand sides that are solved for at once: a register of a processor
KINDS = {np.dtype(np.float64): "double[]", np.dtype(np.int32): "int[]", np.dtype(np.int64): "long[]"}
DECLARED = """
typedef struct {
    long size, entries, blocks, below_all;
    const int *begin, *columns, *place, *order, *turn, *first, *below;
    const long *update;
    const int *target;
} pattern;
typedef struct {
    long count, seen;
    const double *outward, *by_rate, *by_place;
    double *inverse;
    const int *begin, *columns;
    const double *shares;
    const int *back, *rows;
    const double *back_shares;
} modal;
long factor(const pattern *p, long steps, const double *mass, const double *damping, const double *stiffness,
            const double *duration, const double *inner, const double *square, double *factors, double *work);
void multiply(const pattern *p, long positions, long many, const double *values, const double *vectors, double *result);
void solve(const pattern *p, long positions, long many, const double *factors, double *right, double *work);
void march(const pattern *p, long first, long last, const double *damping, const double *stiffness, const double *load,
           const double *gain, const double *duration, const double *inner, const double *weights,
           const double *square, const double *points, const double *factors, const modal *modes, double pace,
           const double *starts, double *ends, double *accelerations, double *work);
void march_many(const pattern *p, long first, long last, const double *damping, const double *stiffness,
                const double *load, const double *gain, const double *duration, const double *inner,
                const double *weights, const double *square, const double *points, const double *factors,
                const modal *modes, double pace, const double *starts, double *ends, double *accelerations,
                double *work);
long factor_modal(const pattern *p, const modal *d, long steps, const double *duration, const double *inner,
                  const double *square, const double *factors, double *work);
void tabulate(uintptr_t kernel, long positions, long cells, long given, long made, const double *values,
              const double *places, double *results);
void products(long positions, long pairs, const int *left, const int *right, const int *target, const double *one,
              long one_stride, const double *other, long other_stride, double *result, long stride);
void collect(long rows, long entries, const long *place, const double *values, long size, double *result);
"""


@cache
def kernels(stages: int) -> Any:
    """Give the compiled loops, from the cache of compiled forms or compiled now.

    Parameters
    ----------
    stages
        Unknowns of a block: collocation points of a step, or 1 for a matrix itself.

    Raises
    ------
    SolverError
        When there is no C compiler.
    """
    text = f"#define S {stages}\n#define LANES {LANES}\n{SOURCE.read_text(encoding='utf-8')}"
    whole = text + MARCH.read_text(encoding="utf-8") + DECLARED + sys.version
    name = f"fenics_mech_kernels_{hashlib.sha256(whole.encode()).hexdigest()[:16]}"
    return compile_safely(lambda folder: _loaded(folder, name, text))


def _loaded(folder: Path, name: str, text: str) -> Any:
    """Load a compiled module from a folder, where it is compiled if it is not there yet."""
    found = list(folder.glob(f"{name}.*.so"))
    if not found:
        builder = FFI()
        builder.cdef(DECLARED)
        flags = ["-O3", "-fopenmp-simd"]
        builder.set_source(name, text, include_dirs=[str(MARCH.parent)], extra_compile_args=flags)
        making = folder / f"{name}.making"
        made = Path(builder.compile(tmpdir=str(making), verbose=False))
        made.rename(folder / made.name)  # in one step: another process sees it whole or not at all
        shutil.rmtree(making)
        found = [folder / made.name]
    spec = importlib.util.spec_from_file_location(name, found[0])
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def pointer(module: Any, array: NDArray[Any] | None) -> Any:
    """Give C the numbers of an array, which has to be contiguous and of doubles, ints or longs; None is no array.

    The pointer keeps the array alive: a copy made for the call only must not be freed before it.
    """
    if array is None:
        return module.ffi.NULL
    return module.ffi.from_buffer(KINDS[array.dtype], array)
