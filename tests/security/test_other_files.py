"""What else a stranger may give: measurements, results, and a folder with files that libraries read."""

import io
import os
import struct
import subprocess
import sys
from pathlib import Path

import h5py
import numpy as np
import pytest

from fenics_mech import Result
from fenics_mech._compiling import compile_safely
from fenics_mech.analysis import STEPS
from fenics_mech.errors import ResultError, SceneError
from fenics_mech.recovery.measured import read_measurement
from fenics_mech.recovery.saved import seal_of
from tests.studies.processes import ENVIRONMENT
from tests.studies.test_sweep import ARM, SHORT

DEMO = Path(__file__).parents[2] / "demos" / "four_bar.toml"
SECRET = "hunter:x:0"


@pytest.mark.parametrize(
    "content",
    [
        f"{SECRET}:1\n{SECRET}:2\n".encode(),
        f"angle, strain\n0, {SECRET}\n".encode(),
        f"angle, strain\n0, 1e-4\n{SECRET}\n".encode(),
        f"angle, strain\n0, 1e-4, {SECRET}\n".encode(),
        f"angle, strain\n\xff{SECRET}\n".encode("latin-1"),
        f'angle, strain\n"{SECRET}'.encode() + b"\x00\n",
        b"angle, strain\n0, 81276\n",
    ],
)
def test_errors_about_a_measurement_do_not_tell_what_the_file_holds(content, tmp_path):
    (tmp_path / "shadow").write_bytes(content)
    with pytest.raises(SceneError) as caught:
        read_measurement(tmp_path / "shadow")
    assert "hunter" not in str(caught.value)
    assert "81276" not in str(caught.value)
    assert "Expected: a header line, then two columns" in str(caught.value)


@pytest.mark.parametrize("kind", ["pipe", "device", "folder", "too large"])
def test_a_measurement_that_may_never_end_is_not_read(kind, tmp_path):
    path = tmp_path / "coupler.csv"
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "device":
        path.symlink_to("/dev/zero")
    elif kind == "folder":
        path.mkdir()
    else:
        path.touch()
        os.truncate(path, 10**12)
    with pytest.raises(SceneError, match="cannot read the measurements"):
        read_measurement(path)


def saved(folder, fill):
    """Save an HDF5 file as a result, with the seal that anyone can compute."""
    content = io.BytesIO()
    with h5py.File(content, "w") as file:
        file.attrs["fenics_mech"] = "1"
        fill(file)
    (folder / "result.nc").write_bytes(content.getvalue() + seal_of(content.getvalue()))
    return folder / "result.nc"


@pytest.mark.parametrize("kind", ["data of another file", "a link to another file", "virtual data", "a group"])
def test_a_result_takes_nothing_from_other_files(kind, tmp_path):
    (tmp_path / "secret").write_bytes(b"\1" * 80)
    with h5py.File(tmp_path / "secret.h5", "w") as other:
        other["x"] = np.ones(10)

    def fill(file):
        if kind == "data of another file":
            file.create_dataset("x", (10,), "f8", external=[(str(tmp_path / "secret"), 0, 80)])
        elif kind == "a link to another file":
            file["x"] = h5py.ExternalLink(str(tmp_path / "secret.h5"), "x")
        elif kind == "virtual data":
            layout = h5py.VirtualLayout((10,), "f8")
            layout[:] = h5py.VirtualSource(str(tmp_path / "secret.h5"), "x", (10,))
            file.create_virtual_dataset("x", layout)
        else:
            file.create_group("x")

    with pytest.raises(ResultError, match="'x' is not in the file itself"):
        Result.load(saved(tmp_path, fill))


def test_a_result_that_would_unpack_to_far_more_than_its_size_is_refused(tmp_path):
    bomb = saved(tmp_path, lambda file: file.create_dataset("x", (10**10,), "f8", chunks=(10**6,), compression="gzip"))
    with pytest.raises(ResultError, match=r"its data would take 8e\+10 bytes"):
        Result.load(bomb)


@pytest.mark.parametrize("scene", ["", "{}", "[1]", '{"name": "\\u001b[31m"}', "[" * 100_000])
def test_a_result_whose_scene_is_none_is_an_error_of_ours(scene, tmp_path):
    result = Result.load(saved(tmp_path, lambda file: file.attrs.__setitem__("scene", scene[:60_000])))
    with pytest.raises(ResultError, match="holds no scene that can be analysed") as caught:
        _ = result.scene
    assert str(caught.value).isprintable()


def test_forms_are_not_compiled_in_the_current_folder(tmp_path, monkeypatch):
    """There dolfinx and ffcx read options of the C compiler."""
    monkeypatch.chdir(tmp_path)
    assert Path(compile_safely(lambda folder: os.getcwd())) != tmp_path
    assert Path.cwd() == tmp_path


@pytest.mark.parametrize("command", ["check", "modes"])  # without these libraries, and with them
def test_options_of_libraries_in_the_current_folder_are_not_read(command, tmp_path):
    (tmp_path / ".petscrc").write_text("-log_view :broken\n")
    (tmp_path / "petscrc").write_text("-log_view :broken\n")
    (tmp_path / "matplotlibrc").write_text("no_such_key: 1\n")
    arguments = [sys.executable, "-m", "fenics_mech", command, DEMO]
    done = subprocess.run(arguments, cwd=tmp_path, capture_output=True, timeout=60, check=True)
    assert set(done.stderr.decode().split()) <= set(STEPS)  # that a slow machine tells
    assert {path.name for path in tmp_path.iterdir()} - {"out"} == {".petscrc", "matplotlibrc", "petscrc"}


@pytest.mark.slow
def test_processes_that_share_work_read_no_modules_and_options_in_the_current_folder(tmp_path):
    """Python itself would, as it starts the process that starts the others by `-c`."""
    (own := tmp_path / "own").mkdir()
    start = "from fenics_mech.__main__ import main\nif __name__ == '__main__':\n    main()"  # as `fenics-mech` is
    (own / "start.py").write_text(start)
    (stranger := tmp_path / "stranger").mkdir()
    (stranger / ".petscrc").write_text("-log_view :broken\n")
    for name in ("xarray", "numpy", "multiprocessing"):
        (stranger / f"{name}.py").write_text(f"open({name!r}, 'w').close()")
    (stranger / "arm.toml").write_text(ARM)
    arguments = [sys.executable, own / "start.py", "sweep", "arm.toml", "--over", SHORT, "--jobs", "2"]
    done = subprocess.run(arguments, cwd=stranger, env=ENVIRONMENT, capture_output=True, timeout=60, check=True)
    assert b"options" not in done.stdout + done.stderr
    assert not {"xarray", "numpy", "multiprocessing", "broken"} & {path.name for path in stranger.iterdir()}


def test_variables_of_a_result_that_share_one_place_in_the_file_are_not_read(tmp_path):
    """The header of NetCDF 3 gives each variable's place: 1,000 of a million bytes each may be the same million."""

    def named(text):
        return struct.pack(">i", len(text)) + text + b"\0" * (-len(text) % 4)

    size, count = 1_000_000, 1000
    head = b"CDF\x01" + struct.pack(">i", 0) + struct.pack(">ii", 10, 1) + named(b"a") + struct.pack(">i", size)
    head += struct.pack(">ii", 12, 1) + named(b"fenics_mech") + struct.pack(">ii", 2, 1) + b"1\0\0\0"
    head += struct.pack(">ii", 11, count)
    variables = [named(b"v%05d" % i) + struct.pack(">6i", 1, 0, 0, 0, 1, size) for i in range(count)]
    start = struct.pack(">i", len(head) + sum(len(variable) + 4 for variable in variables))
    content = head + b"".join(variable + start for variable in variables) + b"\1" * size
    (tmp_path / "result.nc").write_bytes(content + seal_of(content))
    with pytest.raises(ResultError, match=r"its data would take 1e\+09 bytes"):
        Result.load(tmp_path / "result.nc")
