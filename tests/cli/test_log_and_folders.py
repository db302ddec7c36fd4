"""The log is quiet unless it is asked for; a run leaves its warnings; a failed one leaves no folder."""

import subprocess
import sys

from tests.common import DEMOS

QUICK = ("--no-plots", "--no-report")


def called(*arguments):
    """Run the command in a process of its own: the log of this one is that of all tests."""
    words = [sys.executable, "-m", "fenics_mech", *map(str, arguments)]
    return subprocess.run(words, capture_output=True, text=True, timeout=120, check=False)


def scene_of(tmp_path, **changed):
    """Write the slider-crank with other lines, by their key."""
    lines = (DEMOS / "slider_crank.toml").read_text().splitlines()
    for key, value in changed.items():
        lines = [f"{key} = {value}" if line.startswith(f"{key} =") else line for line in lines]
    path = tmp_path / "scene.toml"
    path.write_text("\n".join(lines))
    return path


def test_log_is_quiet_unless_asked_for_and_warnings_are_kept(tmp_path):
    scene, folder = scene_of(tmp_path), tmp_path / "out"
    quiet = called("run", scene, *QUICK, "-o", folder)
    assert quiet.returncode == 0
    assert "fenics_mech.analysis" not in quiet.stderr
    assert "linear theory leaves out" in (folder / "warnings.txt").read_text()
    loud = called("run", scene, *QUICK, "-o", folder, "--verbose")
    assert "fenics_mech.solve.periodic: Newton" in loud.stderr
    assert loud.stdout == quiet.stdout


def test_failed_run_leaves_no_folder_but_those_that_were_there(tmp_path):
    (tmp_path / "kept").mkdir()
    scene = scene_of(tmp_path, speed='"60000 rpm"')
    done = called("run", scene, *QUICK, "-o", tmp_path / "kept" / "new" / "out")
    assert done.returncode == 1
    assert "error:" in done.stderr
    assert list((tmp_path / "kept").iterdir()) == []
