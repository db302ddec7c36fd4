"""Faults of the machine and of its user: a full disk, a killed process, Ctrl-C, damaged files, numbers out of reach.

Each case says what is hard. Right is the same for all: one line that says what went wrong, an exit code that is not 0,
no traceback, no file that is not whole, and a next run that works.
"""

import fcntl
import os
import random
import re
import signal
import subprocess
import sys

import numpy as np
import pytest
import xarray as xr

from fenics_mech import Result, _compiling, analyse
from fenics_mech._compiling import compile_safely
from fenics_mech._guard import guarded
from fenics_mech.errors import MechanismError, ResultError, SolverError
from fenics_mech.scene.factories import seed_four_bar
from tests.common import ROOT

DEMO = str(ROOT / "demos" / "four_bar.toml")
QUICK = "[analysis]\nmethod = 'quasi-static'\nsub_intervals = 200\nstations = 5\n"
COMMAND = [sys.executable, "-m", "fenics_mech"]


def started(*arguments, program=None, **options):
    """Start `fenics-mech`, or a program in its place, in a process of its own."""
    command = COMMAND if program is None else [sys.executable, "-c", program]
    options = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True, "cwd": ROOT} | options
    return subprocess.Popen([*command, *map(str, arguments)], **options)


def ended(process):
    out, err = process.communicate(timeout=300)
    return process.returncode, out, err


@pytest.fixture
def quick(tmp_path, demo_text):
    """Write a scene that takes no time."""
    scene = tmp_path / "quick.toml"
    scene.write_text(demo_text.replace('effects = "auto"', "").split("[analysis]")[0] + QUICK)
    return scene


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    """Save a result and give its bytes."""
    scene = seed_four_bar(analysis={"sub_intervals": 12, "allow_coarse": True, "method": "quasi-static", "stations": 5})
    path = analyse(scene).save(tmp_path_factory.mktemp("saved") / "result.nc")
    return path.read_bytes()


# Numbers ------------------------------------------------------------------------------------------------------------


def damped(damping):
    return seed_four_bar(
        analysis={"sub_intervals": 48, "stability": False, "stations": 5},
        dampers={"d": {"joint": "B", "damping": damping}},
    )


@pytest.mark.parametrize("damping", [1e12, 1e13, 1e14, 1e16, 1e20, 1e30])
@pytest.mark.parametrize("effects", ["auto", ("coupling",)])
def test_damper_that_is_as_good_as_rigid_is_refused_by_its_name(damping, effects):
    """The angle behind it settles by 1e-12 in a cycle, or less: from 1e12 N m s/rad on its strains were wrong."""
    with pytest.raises(SolverError, match=r"The damper 'd' of 1e\+\d\d N m s/rad is as good as rigid"):
        analyse(damped(damping).changed(effects=effects))


def test_two_dampers_that_are_as_good_as_rigid_are_refused():
    """At 1e11 N m s/rad each the strains were 13 % off."""
    scene = damped(1e11).changed(effects=("coupling",), dampers__e={"joint": "C", "damping": 1e11})
    with pytest.raises(SolverError, match=r"lost to rounding: .* of it, by estimate. The damper 'd'"):
        analyse(scene)


@pytest.mark.parametrize("damping", [1e9, 1e10, 1e11])
def test_what_rounding_takes_behind_a_stiff_damper_is_told(damping):
    """Measured 0.25 to 0.4 of the strains' true error, which is that of the state that a cycle begins with."""
    scenes = (damped(size).changed(effects=("coupling",), analysis__allow_coarse=True) for size in (damping, 1e7))
    found, held = (analyse(scene).data for scene in scenes)
    true = float(np.abs(found["strain"] - held["strain"]).max())
    assert 0.1 < float(found["strain_error"].sel(source="rounding").max()) / true < 10


def test_stiff_damper_that_is_let_through_is_right():
    """A damper of 1e6 N m s/rad already holds the joint as if welded: one of 1e9 gives the same strains to 0.3 %."""
    strain, held = (
        analyse(damped(damping).changed(analysis__allow_coarse=True)).data["strain"] for damping in (1e9, 1e6)
    )
    assert float(np.abs(strain - held).max()) < 3e-3 * float(np.abs(held).max())


def test_numbers_that_overflow_are_an_error(seed):
    with pytest.raises(SolverError, match="too large or too small"):
        analyse(seed.changed(drive__speed=1e24))


def test_singular_matrix_is_an_error_of_ours():
    with pytest.raises(SolverError, match=r"Singular matrix.*very different size"), guarded():
        np.linalg.solve(np.zeros((2, 2)), np.ones(2))


# Compiled forms -----------------------------------------------------------------------------------------------------

ASSEMBLE = (
    "from fenics_mech.scene import load; from fenics_mech.beams.element_matrices import assemble_beams; "
    "from fenics_mech.beams.mesh import mesh_scene; "
    f"scene = load({DEMO!r}); assemble_beams(scene, mesh_scene(scene))"
)
KILLED = f"import cffi, os, signal; cffi.FFI.compile = lambda *a, **k: os.kill(os.getpid(), signal.SIGKILL); {ASSEMBLE}"


def unfinished(folder):
    return [path for path in folder.glob("*.c") if not path.with_suffix(".c.cached").exists()]


@pytest.mark.slow
def test_killed_compilation_does_not_spoil_the_next(tmp_path):
    """Ffcx waits 10 s for what a killed process has begun, and then gives up: in every run, until someone cleans up."""
    folder, environment = tmp_path / "fenics_mech", os.environ | {"XDG_CACHE_HOME": str(tmp_path)}
    code, _, _ = ended(started(program=KILLED, env=environment))
    assert code == -signal.SIGKILL
    (begun,) = unfinished(folder)
    code, out, err = ended(started(program=ASSEMBLE, env=environment))
    assert (code, out, err) == (0, "", "")
    assert not unfinished(folder)
    assert list(folder.glob(f"{begun.stem}.*.so"))


@pytest.mark.slow
def test_two_runs_share_an_empty_cache(tmp_path):
    """The second finds what the first is compiling, and must wait for it however long it takes."""
    environment = os.environ | {"XDG_CACHE_HOME": str(tmp_path)}
    both = [started(program=ASSEMBLE, env=environment) for _ in range(2)]
    assert [ended(process) for process in both] == [(0, "", "")] * 2
    assert not unfinished(tmp_path / "fenics_mech")


def test_cache_is_locked_while_a_form_is_compiled(tmp_path, monkeypatch):
    """So that the second run waits however long it takes; ffcx itself gives up after 10 s."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))

    def locked(folder):
        with (folder / "lock").open() as lock, pytest.raises(BlockingIOError):
            fcntl.flock(lock, fcntl.LOCK_SH | fcntl.LOCK_NB)
        return folder

    assert compile_safely(locked) == tmp_path / "fenics_mech"


@pytest.mark.parametrize("cache", ["/proc/nowhere", "/dev/null", DEMO])
def test_cache_that_cannot_be_written_is_done_without(monkeypatch, cache):
    monkeypatch.setenv("XDG_CACHE_HOME", cache)
    assert not compile_safely(lambda folder: folder).is_relative_to(cache)


def test_cache_on_a_full_disk_is_done_without_and_freed(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))

    def make(folder):
        (folder / "libffcx_forms_1.c").write_text("half of it")
        if folder.is_relative_to(tmp_path):
            raise OSError(28, "No space left on device")
        return folder

    assert not compile_safely(make).is_relative_to(tmp_path)
    assert [path.name for path in (tmp_path / "fenics_mech").iterdir()] == ["lock"]


def test_computer_without_a_compiler_is_told_so(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(_compiling, "_own_folder", lambda: tmp_path)
    monkeypatch.setenv("CC", "/bin/false")
    from fenics_mech.beams.element_matrices import assemble_beams
    from fenics_mech.beams.mesh import mesh_scene

    scene = seed_four_bar()
    with pytest.raises(SolverError, match=r"cannot be compiled: .*C compiler"):
        assemble_beams(scene, mesh_scene(scene)).mass  # noqa: B018


# Files --------------------------------------------------------------------------------------------------------------


# Runs the command and lets no file grow beyond so many bytes, as on a disk that is full; MPI has its own files by then.
LIMITED = """
import resource, sys
from mpi4py import MPI
sys.dont_write_bytecode = True
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv.pop(1)),) * 2)
from fenics_mech.__main__ import main
main()
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("size", "command", "whole"),
    [
        (60_000, ["run", "--no-plots"], set()),  # HDF5 ended the process
        (460_000, ["run", "--csv", "--no-plots"], set()),  # smaller than the result, larger than each table
        (20_001, ["mesh"], {"mesh.msh", "mesh.vtu", "mesh.xdmf"}),  # small enough
        (20_000, ["modes"], {"frequencies.csv", "running_frequencies.csv"}),  # larger than each, smaller than the plot
        (10_000, ["modes"], set()),
    ],
)
def test_full_disk_leaves_whole_files_only(tmp_path, quick, size, command, whole):
    assert ended(started(command[0], quick, "-o", tmp_path / "before", *command[1:]))[0] == 0  # all forms are compiled
    folder = tmp_path / "out"
    code, _, err = ended(started(size, command[0], quick, "-o", folder, *command[1:], program=LIMITED))
    if command != ["mesh"]:
        assert code == 1
        assert "Traceback" not in err
        assert re.fullmatch("error: .*cannot be written: File too large.*", err.splitlines()[-1])
    assert {path.name for path in folder.glob("*")} == whole
    for name in whole & {"result.nc"}:
        assert np.isfinite(Result.load(folder / name).data["strain"]).all()


@pytest.mark.slow
def test_film_on_a_full_disk_is_an_error(tmp_path, saved):
    """Ffmpeg is a process of its own, and its writer does not ask how it ended."""
    (tmp_path / "result.nc").write_bytes(saved)
    film = tmp_path / "out" / "motion.mp4"
    command = ["animate", tmp_path / "result.nc", "-o", film, "--frames", 8]
    code, _, err = ended(started(4_000, *command, program=LIMITED))
    assert code == 1
    assert "Traceback" not in err
    assert re.fullmatch("error: .*ffmpeg.*", err.splitlines()[-1])  # a busy machine tells its progress before
    assert not film.parent.exists()


@pytest.mark.parametrize("out", ["/dev/full", None])
def test_output_that_nobody_takes_is_no_traceback(out):
    """A full disk behind `> file`, and a closed output: UFL asks it whether it is a terminal."""
    if out is None:
        process = started("check", DEMO, stdout=None, preexec_fn=lambda: os.close(1))
        code, _, err = ended(process)
        assert (code, err) == (0, "")
        return
    with open(out, "w") as full:
        code, _, err = ended(started("schema", stdout=full))
    assert code != 0
    assert "Traceback" not in err
    assert "No space left" in err


DAMAGE = {
    "cut": lambda content: content[: len(content) // 2],
    "empty": lambda content: b"",
    "longer": lambda content: content + b"x",
    "text": lambda content: b"theta,strain\n0,0\n",
    "zeros": lambda content: bytes(len(content)),
    "no seal": lambda content: content[:-83],
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_damaged_result_is_refused_without_noise(tmp_path, saved, damage, capfd):
    path = tmp_path / "result.nc"
    path.write_bytes(DAMAGE[damage](saved))
    with pytest.raises(ResultError, match=r"result\.nc: this file is not a result of fenics_mech, or was cut"):
        Result.load(path)
    assert capfd.readouterr() == ("", "")


def test_single_wrong_byte_anywhere_is_found(tmp_path, saved):
    """HDF5 ended the process with a segmentation fault over some of them, and gave other numbers for others."""
    chance, path = random.Random(1989), tmp_path / "result.nc"
    for _ in range(60):
        content = bytearray(saved)
        content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
        path.write_bytes(content)
        with pytest.raises(ResultError):
            Result.load(path)
    path.write_bytes(saved)
    assert Result.load(path).scene.name


def test_sealed_result_is_still_netcdf(tmp_path, saved):
    path = tmp_path / "result.nc"
    path.write_bytes(saved)
    with xr.open_dataset(path) as data:
        assert data.attrs["title"] == Result.load(path).data.attrs["title"]


@pytest.mark.parametrize("name", ["pipe", "folder", "nowhere", "foreign"])
def test_what_is_no_result_is_refused_at_once(tmp_path, name, capfd):
    path = tmp_path / name
    if name == "pipe":
        os.mkfifo(path)
    elif name == "folder":
        path.mkdir()
    elif name == "foreign":
        xr.Dataset({"a": ("x", np.ones(3))}).to_netcdf(path, engine="h5netcdf")
    with pytest.raises(
        ResultError, match="not a result of fenics_mech" if name == "foreign" else "cannot be read as a result"
    ):
        Result.load(path)
    assert capfd.readouterr() == ("", "")


# Ctrl-C -------------------------------------------------------------------------------------------------------------

INTERRUPTED = """
import os, signal, sys
place = sys.argv.pop(1)
def interrupt(*arguments, **options):
    os.kill(os.getpid(), signal.SIGINT)
class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == place:
            interrupt()
sys.meta_path.insert(0, Finder())
if place == "write":
    from pathlib import Path
    Path.write_bytes = interrupt
if place == "dropped":
    class Dropping:
        def __del__(self):
            interrupt()
            for _ in range(1000):
                pass
    import fenics_mech.analysis
    whole = fenics_mech.analysis.fine_enough
    fenics_mech.analysis.fine_enough = lambda *args: (Dropping(), whole(*args))[1]
from fenics_mech.__main__ import main
main()
"""


PLACES = ("typer", "numpy", "pydantic", "petsc4py", "dolfinx", "matplotlib", "write", "dropped")


@pytest.mark.slow
@pytest.mark.parametrize("place", PLACES)
def test_interrupt_at_any_point_is_one_line(tmp_path, quick, place):
    """While modules are imported, where C code drops it, and while a file is written."""
    folder = tmp_path / "out"
    code, out, err = ended(started(place, "run", quick, "-o", folder, program=INTERRUPTED))
    assert (code, out) == (130, "")
    *steps, last = err.splitlines()  # a slow machine tells how far it is
    assert last == "interrupted"
    assert all(step.islower() and ":" not in step for step in steps)  # names of steps, and no error
    assert not list(folder.glob("*"))
    assert not list(folder.glob(".*"))


def test_every_error_of_the_program_can_be_caught_as_one():
    assert issubclass(SolverError, MechanismError)
    assert issubclass(ResultError, MechanismError)
