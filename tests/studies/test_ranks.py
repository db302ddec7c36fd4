"""An analysis that is shared by processes: the same to the last bit, one voice, and one error for all."""

import pytest

from fenics_mech.analysis import analyse
from fenics_mech.recovery import Result
from fenics_mech.scene import write_scene
from fenics_mech.scene.factories import seed_four_bar
from tests.studies.processes import MPIRUN, finished

pytestmark = pytest.mark.skipif(MPIRUN is None, reason="no mpirun")


@pytest.mark.slow
def test_two_processes_find_the_same_to_the_last_bit(tmp_path):
    # 61 positions: the parts differ in size
    scene = seed_four_bar(
        effects=("coupling", "large-rotations"),
        mesh__elements=2,
        analysis={"sub_intervals": 61, "allow_coarse": True, "stages": 2, "solver": "collocation"},
    )
    write_scene(scene, tmp_path / "seed.toml")
    words = "-m", "fenics_mech", "run", tmp_path / "seed.toml", "--no-plots", "-o", tmp_path / "out"
    ended = finished(*words, ranks=2)
    assert ended.returncode == 0, ended.stderr
    assert ended.stdout.count("Wrote result.nc") == 1
    found = Result.load(tmp_path / "out" / "result.nc")
    alone = Result.load(analyse(found.scene).save(tmp_path / "alone.nc"))
    assert found.data.identical(alone.data)


@pytest.mark.slow
def test_a_scene_that_is_wrong_is_one_message(tmp_path):
    (tmp_path / "bad.toml").write_text("nothing = 1")
    arguments = ("-m", "fenics_mech", "run", tmp_path / "bad.toml", "-o", tmp_path / "out")
    ended = finished(*arguments, ranks=2)
    assert ended.returncode == 1
    assert ended.stderr.count("error:") == 1
