"""The table ``[petsc]`` of a scene: which options of PETSc and SLEPc it may set, and to which values.

PETSc has options that load code, and options that write files. A scene may come from a stranger, so that it sets only
those that choose a method or decide how it converges. Each is listed here with its values.
"""

from __future__ import annotations

import difflib
from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import AfterValidator, WithJsonSchema

from fenics_mech.errors import SceneError, shortened

Kind = dict[str, Any]  # of values that an option takes, as a JSON Schema
SWITCH: Kind = {"type": "boolean"}


def _number(least: float, most: float) -> Kind:
    return {"type": "number", "minimum": least, "maximum": most}


def _whole(least: int, most: int) -> Kind:
    return {"type": "integer", "minimum": least, "maximum": most}


def _names(text: str) -> Kind:
    return {"enum": text.split()}


def _of(part: str, options: Mapping[str, Kind]) -> dict[str, Kind]:
    """Give the options of a part of a solver, such as the KSP of an ST."""
    return {part + name: kind for name, kind in options.items()}


SHARE = _number(0, 1)
RELATIVE = _number(0, 1e-6)  # of what nothing else checks: looser, its error would show in no estimate
ABSOLUTE = _number(0, 1e30)
TIMES = _whole(1, 1_000_000)
FEW = _whole(1, 1000)

FACTORS: dict[str, Kind] = {
    "pc_factor_fill": _number(1, 20),
    "pc_factor_zeropivot": RELATIVE,
    "pc_factor_mat_ordering_type": _names("natural nd 1wd rcm qmd rowlength"),
}
FACTORISED: dict[str, Kind] = FACTORS | {
    "ksp_type": _names("preonly cg gmres fgmres bcgs"),
    "ksp_rtol": RELATIVE,
    "ksp_max_it": TIMES,
    "pc_type": _names("lu cholesky"),
}
BLOCK: dict[str, Kind] = FACTORS | {
    "ksp_type": _names("preonly gmres fgmres lgmres gcr bcgs bcgsl ibcgs fbcgs tfqmr tcqmr"),
    "pc_type": _names("none jacobi sor ilu icc lu cholesky svd"),
    "pc_factor_levels": _whole(0, 20),
    "pc_factor_shift_type": _names("none nonzero positive_definite inblocks"),
    "pc_factor_shift_amount": ABSOLUTE,
}
CHECKED: dict[str, Kind] = (  # of a solver whose answer is put into the equations, however it came about
    BLOCK
    | {
        "ksp_rtol": SHARE,
        "ksp_atol": ABSOLUTE,
        "ksp_divtol": _number(1, 1e30),
        "ksp_max_it": TIMES,
        "ksp_norm_type": _names("none preconditioned unpreconditioned natural"),
        "ksp_pc_side": _names("left right symmetric"),
        "ksp_gmres_restart": FEW,
        "ksp_gmres_modifiedgramschmidt": SWITCH,
        "ksp_bcgsl_ell": _whole(1, 20),
        "pc_type": _names("none jacobi bjacobi sor ilu icc lu cholesky asm gamg svd"),
        "pc_bjacobi_blocks": FEW,
        "pc_asm_blocks": FEW,
        "pc_asm_overlap": _whole(0, 20),
        "pc_sor_omega": _number(0, 2),
        "pc_sor_its": FEW,
    }
    | _of("sub_", BLOCK)
)
EIGENVALUES: dict[str, Kind] = {
    "eps_type": _names("krylovschur arnoldi lapack subspace power gd jd"),
    "eps_tol": RELATIVE,
    "eps_max_it": TIMES,
    "eps_ncv": _whole(1, 10_000),
    "eps_mpd": _whole(1, 10_000),
    "eps_krylovschur_restart": _number(0.1, 0.9),
}
SHIFTED: dict[str, Kind] = {
    "eps_type": _names("krylovschur arnoldi lapack subspace power gd jd lobpcg rqcg"),
    "st_type": _names("shift sinvert cayley precond"),
    **_of("st_", FACTORISED),
}
MULTIPLIERS: dict[str, Kind] = EIGENVALUES | {"eps_nev": FEW}
PARTS: dict[str, dict[str, Kind]] = {"periodic_": CHECKED, "modes_": EIGENVALUES | SHIFTED, "stability_": MULTIPLIERS}
OPTIONS = {prefix + name: kind for prefix, options in PARTS.items() for name, kind in options.items()}


def takes(kind: Kind, value: Any) -> bool:
    """Whether a value is of a kind."""
    if "enum" in kind:
        return value in kind["enum"]
    if isinstance(value, bool) or kind is SWITCH:
        return isinstance(value, bool) and kind is SWITCH
    return isinstance(value, int if kind["type"] == "integer" else int | float) and (
        kind["minimum"] <= value <= kind["maximum"]
    )


def _in_words(kind: Kind) -> str:
    if "enum" in kind:
        return f"one of {', '.join(map(repr, kind['enum']))}"
    if kind is SWITCH:
        return "true or false"
    return f"a {'whole ' * (kind['type'] == 'integer')}number from {kind['minimum']:g} to {kind['maximum']:g}"


def _check_options(options: dict[str, Any]) -> dict[str, Any]:
    """Give the options as they are; raise `SceneError` where one is not listed, or its value is not of its kind."""
    for key, value in options.items():
        if key not in OPTIONS:
            raise SceneError("unknown option of a solver", place=f"petsc.{shortened(key)[1:-1]}", hint=_nearest(key))
        if not takes(OPTIONS[key], value):
            raise SceneError(f"must be {_in_words(OPTIONS[key])}, found {shortened(value)}", place=f"petsc.{key}")
    return options


def _nearest(key: str) -> str:
    """Say which option may have been meant."""
    solvers = tuple(PARTS)
    tried = [key] if key.startswith(solvers) else [prefix + key for prefix in solvers]
    near = [name for each in tried for name in difflib.get_close_matches(each[:100], OPTIONS, n=1, cutoff=0.75)]
    starts = f"An option starts with its solver: {', '.join(solvers)}"
    return f"Did you mean {near[0]!r}?" if near else f"{starts}. `fenics-mech schema` lists all options"


OF_PARTS = {"periodic_": "periodic motions", "modes_": "natural frequencies", "stability_": "stability"}


def _described(name: str) -> str:
    """Say in one sentence what an option is."""
    part = next(part for part in PARTS if name.startswith(part))
    return f"Option -{name.removeprefix(part)} of PETSc or SLEPc, for {OF_PARTS[part]}: {_in_words(OPTIONS[name])}."


SolverOptions = Annotated[
    dict[str, Any],
    AfterValidator(_check_options),
    WithJsonSchema(
        {
            "type": "object",
            "properties": {name: kind | {"description": _described(name)} for name, kind in OPTIONS.items()},
            "additionalProperties": False,
        }
    ),
]
