"""Drawings from strangers: read in a process of their own, from one file, in bounded time and memory."""

import os
from pathlib import Path

import pytest

from fenics_mech.errors import SceneError
from fenics_mech.scene import parse
from fenics_mech.scene.drawing import gmsh_files as files

MESHES = Path(__file__).parents[2] / "meshes"
SCENE = (MESHES / "four_bar.toml").read_text()
GEO = (MESHES / "four_bar.geo").read_text()
ABAQUS = "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n*ELEMENT, TYPE=T2D2\n1, 1, 2\n*ELSET, ELSET=crank\n1\n"


def read(folder, name):
    """Read the scene of the drawn four-bar with another drawing."""
    return parse(SCENE.replace("four_bar.geo", name), folder=folder)


@pytest.mark.parametrize("ending", ["vtu", "xdmf", "med", "e", "h5m", "cgns", "vol.gz", "post.gz", "f3grid", ""])
def test_formats_that_name_files_or_are_compressed_are_not_read(ending, tmp_path):
    """As a .vtu may unpack to a thousand times its size, and an .xdmf takes its numbers from any file."""
    (tmp_path / f"d.{ending}").write_bytes(b"<Xdmf/>")
    with pytest.raises(SceneError, match=r"is no drawing: its ending is .* Draw the mechanism in gmsh"):
        read(tmp_path, f"d.{ending}")


@pytest.mark.parametrize(
    "line", ["*INCLUDE, INPUT=/dev/zero", "  I*nclude , INPUT=secret.inp", "*include,input=secret.inp"]
)
def test_a_drawing_that_includes_a_file_is_refused(line, tmp_path):
    (tmp_path / "secret.inp").write_text(ABAQUS.replace("crank", "secret"))
    (tmp_path / "d.inp").write_text(f"{ABAQUS}{line}\n")
    with pytest.raises(SceneError, match=r"meshio cannot read d\.inp: it includes another file") as caught:
        read(tmp_path, "d.inp")
    assert "secret" not in str(caught.value)


@pytest.mark.parametrize("ending", ["geo", "msh", "inp"])
@pytest.mark.parametrize("kind", ["pipe", "device", "folder", "too large"])
def test_what_may_never_end_is_not_read(kind, ending, tmp_path):
    path = tmp_path / f"d.{ending}"
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "device":
        path.symlink_to("/dev/zero")
    elif kind == "folder":
        path.mkdir()
    else:
        path.touch()
        os.truncate(path, 10**12)
    with pytest.raises(
        SceneError, match=rf"cannot read d\.{ending}: (it is not an ordinary file|Is a dir|it has 10000)"
    ):
        read(tmp_path, f"d.{ending}")


HUGE = {
    "a mesh of many nodes": ("d.msh", "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1000000000000\n1 0 0 0\n"),
    "one of version 4": (
        "d.msh",
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 1000000000000 1 1000000000000\n0 1 0 1000000000000\n1\n",
    ),
    "a script with many elements": ("d.geo", f"{GEO}\nTransfinite Curve {{1:3}} = 100000000;\n"),
}


@pytest.mark.parametrize("case", HUGE)
def test_memory_is_bounded(case, tmp_path, monkeypatch):
    half = files.ReaderLimits(memory=700_000_000)  # of what is allowed, for less time
    monkeypatch.setattr(files, "DRAWING", half)
    name, text = HUGE[case]
    (tmp_path / name).write_text(text)
    with pytest.raises(SceneError, match=rf"cannot read {name}: "):
        read(tmp_path, name)


def test_the_number_of_lines_is_bounded(tmp_path, monkeypatch):
    monkeypatch.setattr(files, "DRAWING", files.ReaderLimits(most_lines=5))
    (tmp_path / "d.geo").write_text(GEO)
    with pytest.raises(SceneError, match=r"d\.geo has \d+ lines in named groups, and at most 5 are taken"):
        read(tmp_path, "d.geo")


def test_the_program_needs_less_than_two_gigabytes():
    """The reader and the program beside it, which has 0.3 GB."""
    limits = files.DRAWING
    assert limits.memory + limits.largest_file + limits.largest_answer <= 1.7e9
    assert limits.patience <= 30


def test_modules_in_the_current_folder_are_not_run(tmp_path, monkeypatch):
    for name in ("gmsh", "numpy", "resource", "json"):
        (tmp_path / f"{name}.py").write_text(f"open({str(tmp_path / 'broken')!r}, 'w')")
    (tmp_path / "d.geo").write_text(GEO)
    monkeypatch.chdir(tmp_path)
    assert set(read(tmp_path, "d.geo").links) == {"crank", "coupler", "follower"}
    assert not (tmp_path / "broken").exists()
