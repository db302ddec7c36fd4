"""How the kernels are compiled: when the package is built or installed, and never in a run."""

from pathlib import Path
from runpy import run_path

from cffi import FFI  # type: ignore[import-untyped]

HERE = Path(__file__).parent
POSES = "const double *r, const double *c, const double *R0"
ENDS = f"long T, long E, long poses, {POSES}, const int *pose, const double *arms"
TARGET = "long size, long entries, double *F, double *M, double *C, double *K"
FUNCTIONS = {
    "beam_strains": f"({ENDS}, const double *par, double *v, double *g, double *h)",
    "relations": f"({ENDS}, const int *code, const double *before, double *v, double *g, double *h)",
    "rotations": (
        "(long n, const double *c, const double *v, const double *a, const double *R0, const double *w0,"
        " const double *al0, double *R, double *J, double *H, double *z1, double *z2, double *z2_c, double *z2_v,"
        " double *u, double *u_c)"
    ),
    "spread": (
        "(long T, long E, long m, const double *g, const double *h, const double *s, const double *predicted,"
        " const double *D, const double *B, const double *v, const int *dof, const int *at, int tangents,"
        f" {TARGET})"
    ),
    "rides": (
        f"({ENDS}, const int *look, const double *marks, const double *bend, const double *pulls, double *v, double *g,"
        " double *f, double *h, double *soft, double *share)"
    ),
    "inner_strains": (
        f"({ENDS}, const double *par, long points, const double *table, double *v, double *g, double *h)"
    ),
    "conditions": f"(long T, long E, const double *g, const int *by, const int *on, {TARGET})",
    "inertia": (
        "(long T, long P, long L, const int *entry, const double *mass, const int *at, const int *own, const int *dof,"
        " const double *acc, const double *J, const double *H, const double *z2_c, const double *z2_v, int tangents,"
        f" double *work, {TARGET})"
    ),
}
CALLS = {
    "beam_strains": "T, E, Poses{poses, r, c, R0}, pose, arms, par, v, g, h",
    "relations": "T, E, Poses{poses, r, c, R0}, pose, arms, code, before, v, g, h",
    "rotations": "n, c, v, a, R0, w0, al0, R, J, H, z1, z2, z2_c, z2_v, u, u_c",
    "spread": "T, E, m, g, h, s, predicted, D, B, v, dof, at, tangents, Target{size, entries, F, M, C, K}",
    "rides": "T, E, Poses{poses, r, c, R0}, pose, arms, look, marks, bend, pulls, v, g, f, h, soft, share",
    "inner_strains": "T, E, Poses{poses, r, c, R0}, pose, arms, par, points, table, v, g, h",
    "conditions": "T, E, g, by, on, Target{size, entries, F, M, C, K}",
    "inertia": (
        "T, P, L, entry, mass, at, own, dof, acc, J, H, z2_c, z2_v, tangents, work, Target{size, entries, F, M, C, K}"
    ),
}
KINDS = {"plane": "Plane", "space": "Space"}
VARIANTS = {  # by name: the function, and what its template takes
    f"{name}_{kind}": (name, of) for name in FUNCTIONS if name != "inner_strains" for kind, of in KINDS.items()
}
VARIANTS |= {
    f"{name}_ride_{kind}": (name, f"{of}, Own<Ride<{of}>::N>")
    for name in ("spread", "conditions")
    for kind, of in KINDS.items()
}
for inside in (1, 2, 3, 4):  # places inside an element: with 4, one element makes a member to 1e-5
    VARIANTS[f"inner_strains_{inside}_plane"] = "inner_strains", f"Plane, {inside}"
    VARIANTS |= {
        f"{name}_inner_{inside}_plane": (name, f"Plane, Own<Inner<Plane, {inside}>::N>")
        for name in ("spread", "conditions")
    }

ORDER = "long N, long entries, const int *order, const int *first, const int *later, const int *to, const int *block"
STEPS = (
    "const int *row, const int *column, const double *h, const double *A, const double *AA, const double *c,"
    " const double *M, const double *C, const double *K"
)
GIVEN = (
    "march_of_steps::Order{N, entries, order, first, later, to, block},"
    " march_of_steps::Steps{row, column, h, A, AA, c, M, C, K}"
)
MARCHES = {  # by name: what it gives, what it takes beside the stages and GIVEN, and what the template takes
    "factor": ("long", "long steps, double *LU", "steps, LU"),
    "missed": ("double", "long steps, const double *LU", "steps, LU"),
    "march": (
        "void",
        "const double *LU, long n, double unit, long steps, long columns, const double *right, const double *gaps,"
        " const int *blow, const double *by_q, double *state, double *a, double *after",
        "LU, n, unit, steps, columns, right, gaps, blow, by_q, state, a, after",
    ),
}
STAGES = range(1, 11)  # a scene may ask for 9, and one more tells the error of the steps
DECLARED = {name: f"{gives} {name}_steps(int S, {ORDER}, {STEPS}, {own})" for name, (gives, own, _) in MARCHES.items()}


def _by_stages(name: str) -> str:
    """Give the function that calls the template of as many stages as are asked for."""
    _, _, call = MARCHES[name]
    cases = "\n".join(f"case {S}: return march_of_steps::{name}<{S}>({GIVEN}, {call});" for S in STAGES)
    return f'static {DECLARED[name]} {{ switch (S) {{ {cases} }} throw "stages"; }}'


builder = FFI()
builder.cdef("const char *built_from(void);")  # the sources, compared on import
builder.cdef("\n".join(f"void {own}{FUNCTIONS[name]};" for own, (name, _) in VARIANTS.items()))
builder.cdef("\n".join(f"{declared};" for declared in DECLARED.values()))
builder.set_source(
    "fenics_mech._kernels._compiled",
    '#include "kernels.hpp"\n#include "march.hpp"\n'
    f'static const char *built_from(void) {{ return "{run_path(str(HERE / "sources.py"))["fingerprint"]()}"; }}\n'
    + "\n".join(
        f"static void {own}{FUNCTIONS[name]} {{ {name}<{of}>({CALLS[name]}); }}" for own, (name, of) in VARIANTS.items()
    )
    + "\n".join(map(_by_stages, MARCHES)),
    source_extension=".cpp",
    include_dirs=[str(HERE)],
    depends=[str(HERE / name) for name in ("jet.hpp", "rotations.hpp", "measures.hpp", "kernels.hpp", "march.hpp")],
    extra_compile_args=["-std=c++17", "-O3", "-fno-math-errno"],
)

if __name__ == "__main__":
    builder.compile(tmpdir=str(HERE.parents[1]), verbose=True)
