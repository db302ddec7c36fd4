"""Systems of all kinds: an answer in whatever encoding there is, or one line and an exit code that is not 0."""

import resource
import subprocess
import sys

import pytest

from tests.studies.processes import ENVIRONMENT
from tests.studies.test_sweep import ARM

NOWHERE = "/proc/nowhere"
LETTERS = {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
RUN = "run", "arm.toml", "--no-report"
WORKING = {  # settings with which everything is written
    "latin-1": {"PYTHONIOENCODING": "latin-1"},
    "ascii": {"PYTHONIOENCODING": "ascii"},
    "no locale": LETTERS,
    "no such backend": {"MPLBACKEND": "nonsense"},
    "backend with a screen": {"MPLBACKEND": "qtagg"},
    "LaTeX that is not there": {"MPLCONFIGDIR": "settings"},
    "no home": {"HOME": None},
    "home that is not there": {"HOME": NOWHERE},
    "no folder can be written": {"HOME": NOWHERE, "XDG_CACHE_HOME": NOWHERE, "MPLCONFIGDIR": NOWHERE},
    "dumb terminal": {"TERM": "dumb"},
    "narrow": {"COLUMNS": "5"},
}


def ran(folder, settings, *, limit=None, script="", **streams):
    """Run the arm in a folder with settings of the environment (None: without one), and give how it ended."""
    (folder / "arm.toml").write_text(ARM)
    (folder / "settings").mkdir()
    (folder / "settings" / "matplotlibrc").write_text("text.usetex: true\n")
    changed = {key: str(folder / value) if value == "settings" else value for key, value in settings.items()}
    environment = {key: value for key, value in (ENVIRONMENT | changed).items() if value is not None}
    program = [sys.executable, "-c", script, *RUN] if script else [sys.executable, "-m", "fenics_mech", *RUN]

    def limited():
        if limit is not None:
            resource.setrlimit(resource.RLIMIT_AS, (limit, limit))

    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | streams
    return subprocess.run(program, cwd=folder, env=environment, timeout=120, check=False, preexec_fn=limited, **streams)


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("name", WORKING)
def test_all_is_written_and_told(name, tmp_path):
    done = ran(tmp_path, WORKING[name])
    out, err = done.stdout.decode("utf-8", "replace"), done.stderr.decode("utf-8", "replace")
    assert done.returncode == 0, err
    assert "Traceback" not in err
    assert "Wrote" in out.replace("\n", "")
    assert {"result.nc", "strain.png"} <= {path.name for path in (tmp_path / "out").iterdir()}
    if "PYTHONIOENCODING" in WORKING[name] or name == "no locale":
        done.stdout.decode(WORKING[name].get("PYTHONIOENCODING", "ascii"))
    assert ("Forms are compiled for this run only" in err) is (WORKING[name].get("XDG_CACHE_HOME") == NOWHERE)


@pytest.mark.slow
@pytest.mark.parametrize("closed", ["stdout", "stderr"])
def test_a_closed_stream_loses_no_file(closed, tmp_path):
    number = {"stdout": 1, "stderr": 2}[closed]
    close = f"import os, sys; os.close({number}); sys.{closed} = None\n"
    script = f"{close}from fenics_mech.__main__ import main\nmain()"
    assert ran(tmp_path, {}, script=script).returncode == 0
    assert (tmp_path / "out" / "result.nc").exists()


@pytest.mark.slow
def test_an_output_that_is_full_is_one_line_and_loses_no_file(tmp_path):
    with open("/dev/full", "w") as full:
        done = ran(tmp_path, {}, stdout=full)
    assert done.returncode == 1
    assert done.stderr.decode().splitlines()[-1] == "error: the output: No space left on device"
    assert (tmp_path / "out" / "result.nc").exists()


@pytest.mark.parametrize("megabytes", [300, 600])
def test_too_little_memory_for_the_libraries_is_one_line(megabytes, tmp_path):
    done = ran(tmp_path, {}, limit=megabytes * 10**6)
    assert done.returncode == 1
    (line,) = done.stderr.decode().splitlines()
    assert line.startswith(f"error: a process may have {megabytes / 1000:g} GB of memory here, and the libraries take")
    assert not (tmp_path / "out").exists()


FAILING = {
    "a library that is missing": (
        "import sys\nsys.modules['xarray'] = None\n",
        "error: a library is missing or cannot be loaded: import of xarray halted",
        set(),
    ),
    "plots that fail": (
        "import fenics_mech.views.figures as figures\n"
        "def fail(*_): raise RuntimeError('latex could not be found')\n"
        "figures._laid_out_and_written = fail\n",
        "Matplotlib cannot draw it: latex could not be found",
        {"result.nc", "warnings.txt"},
    ),
    "dolfinx without memory": (
        "import fenics_mech._fenicsx as module\n"
        "def fail(*_, **__): raise RuntimeError('Error during SCOTCH partitioning')\n"
        "module.gmshio.model_to_mesh = fail\n",
        "error: dolfinx stopped: Error during SCOTCH partitioning. There may be too little memory",
        set(),
    ),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", FAILING)
def test_what_fails_is_one_line_and_what_was_computed_is_kept(name, tmp_path):
    before, line, kept = FAILING[name]
    done = ran(tmp_path, {}, script=f"{before}from fenics_mech.__main__ import main\nmain()")
    assert done.returncode == 1
    assert line in done.stderr.decode().splitlines()[-1]
    assert "Traceback" not in done.stderr.decode()
    found = {path.name for path in (tmp_path / "out").iterdir()} if kept else set()
    assert found == kept
    assert (tmp_path / "out").exists() is bool(kept)
    assert ("Wrote result.nc" in done.stdout.decode()) is bool(kept)
