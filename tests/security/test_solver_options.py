"""The table [petsc]: options of PETSc that run code or write files are none of a scene's."""

import pytest

from fenics_mech._petsc import PETSc, SLEPc
from fenics_mech.errors import SceneError
from fenics_mech.scene import parse, schema
from fenics_mech.scene.solver_options import OPTIONS

FORBIDDEN = {
    "a preconditioner in Python": (
        'modes_st_pc_type = "python"',
        "modes_st_pc_type",
        "must be one of 'lu', 'cholesky'",
    ),
    "its file": ('modes_st_pc_python_type = "scene.toml:Pc"', "modes_st_pc_python_type", "unknown option of a solver"),
    "a linear solver in Python": ('periodic_ksp_type = "python"', "periodic_ksp_type", "must be one of"),
    "a viewer": ('modes_eps_view = "ascii:victim.txt"', "modes_eps_view", "unknown option of a solver"),
    "a monitor": ('periodic_ksp_monitor = "ascii:victim.txt"', "periodic_ksp_monitor", "unknown option of a solver"),
    "a file of options": ('modes_options_file = "scene.toml"', "modes_options_file", "unknown option of a solver"),
    "other modes than the lowest": ("modes_eps_target = 1e9", "modes_eps_target", "unknown option of a solver"),
    "a method for symmetric systems": ('periodic_ksp_type = "cg"', "periodic_ksp_type", "must be one of"),
    "another option behind a value": (
        'modes_st_pc_type = "lu -log_view :victim.txt"',
        "modes_st_pc_type",
        "must be one of 'lu', 'cholesky', found",
    ),
    "an option of no solver": ('log_view = ":victim.txt"', "log_view", "An option starts with its solver: periodic_"),
    "a misspelt option": ('periodic_ksp_typ = "gmres"', "periodic_ksp_typ", "Did you mean 'periodic_ksp_type'?"),
    "a text for a number": ('modes_eps_tol = "1e-9"', "modes_eps_tol", "must be a number from 0 to 1e-06"),
    "an infinite number": ("modes_eps_tol = 1e400", "modes_eps_tol", "must be a number"),
    "a number beyond its range": ("periodic_ksp_gmres_restart = 2000000000", "periodic_ksp_gmres_restart", "to 1000"),
    "a switch for a number": ("modes_eps_max_it = true", "modes_eps_max_it", "must be a whole number"),
    "a list": ("modes_eps_ncv = [20]", "modes_eps_ncv", "must be a whole number"),
    "a long whole number": (f"modes_eps_ncv = 1{'0' * 400}", "modes_eps_ncv", "must be a whole number"),
}


@pytest.mark.parametrize("case", FORBIDDEN)
def test_other_options_are_refused_with_their_place(case, demo_text):
    line, key, message = FORBIDDEN[case]
    with pytest.raises(SceneError) as caught:
        parse(f"{demo_text}\n[petsc]\n{line}\n", file="scene.toml")
    number = len(demo_text.splitlines()) + 3
    assert str(caught.value).startswith(f"scene.toml: petsc.{key} (line {number}): ")
    assert message in str(caught.value)


def test_no_option_runs_code_or_names_a_file():
    """By PETSc's own words for such options and types."""
    words = ("python", "shell", "view", "monitor", "file", "load", "user", "plugin", "history", "mat_type")
    assert not [name for name in OPTIONS if any(word in name for word in words)]
    types = {value for kind in OPTIONS.values() for value in kind.get("enum", ())}
    assert not types & {"python", "shell", "mat", "user", "composite", "galerkin", "ksp", "filter", "history"}


MAKERS = {"ksp": PETSc.KSP, "pc": PETSc.PC, "eps": SLEPc.EPS, "st": SLEPc.ST}


@pytest.mark.parametrize("part", MAKERS)
def test_petsc_has_every_type_that_is_listed(part):
    types = {value for key, kind in OPTIONS.items() if key.endswith(f"_{part}_type") for value in kind["enum"]}
    assert types
    for name in types:
        solver = MAKERS[part]().create(comm=PETSc.COMM_SELF)
        solver.setType(name)
        solver.destroy()


def test_schema_lists_the_options():
    table = schema()["properties"]["petsc"]
    assert table["properties"].keys() == OPTIONS.keys()
    assert table["additionalProperties"] is False
    assert table["properties"]["modes_st_pc_type"]["enum"] == ["lu", "cholesky"]
    assert "for natural frequencies" in table["properties"]["modes_st_pc_type"]["description"]


def test_options_of_a_scene_are_given_as_they_are(demo_text):
    lines = 'periodic_ksp_type = "gmres"', "periodic_ksp_rtol = 1e-12", "modes_eps_max_it = 100"
    text = "\n".join([demo_text, "[petsc]", *lines, "periodic_ksp_gmres_modifiedgramschmidt = true"])
    assert parse(text).petsc == {
        "periodic_ksp_type": "gmres",
        "periodic_ksp_rtol": 1e-12,
        "modes_eps_max_it": 100,
        "periodic_ksp_gmres_modifiedgramschmidt": True,
    }
