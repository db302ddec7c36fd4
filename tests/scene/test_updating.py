"""Scene files of earlier versions: one line says what to change, and `check --update` changes it."""

import re

import pytest
from typer.testing import CliRunner

from fenics_mech.cli import app
from fenics_mech.errors import SceneError
from fenics_mech.scene import Analysis, load
from fenics_mech.scene.updating import GONE, updated
from tests.common import DEMOS

SEED = (DEMOS / "four_bar.toml").read_text()
STATED = '[analysis]\nreduction = "craig-bampton"  # few coordinates\ncutoff = "2 kHz"\n'
OLD = SEED.replace("[analysis]\n", STATED) if "[analysis]" in SEED else f"{SEED}\n{STATED}"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ('[analysis]\nstations = 5\nreduction = "none"  # all\nsub_intervals = 90  # few\n',
         '[analysis]\nstations = 5\nsub_intervals = 90  # few\n'),
        ('analysis = { reduction = "craig-bampton", stations = 5 }  # here\n', 'analysis = { stations = 5 }  # here\n'),
        ('analysis = { stations = 5, cutoff = "2 kHz" }\n', 'analysis = { stations = 5 }\n'),
        ('analysis.reduction = "none"\nname = "reduction = 1"\n', 'name = "reduction = 1"\n'),
        ('[analysis]\ncutoff = 2e3', '[analysis]\n'),
    ],
)  # fmt: skip
def test_gone_keys_are_left_out_and_the_rest_stays(text, expected):
    found, left_out = updated(text)
    assert found == expected
    assert set(left_out) <= set(GONE)
    assert updated(found) == (found, {})


def test_the_message_names_the_line_and_the_command(tmp_path):
    (file := tmp_path / "old.toml").write_text(OLD)
    line = OLD.splitlines().index('reduction = "craig-bampton"  # few coordinates') + 1
    with pytest.raises(SceneError, match=r"analysis\.reduction.*has gone: members keep .*check --update") as raised:
        load(file)
    assert raised.value.line == line


def test_the_command_rewrites_the_file(tmp_path):
    (file := tmp_path / "old.toml").write_text(OLD)
    refused, done, again = (
        CliRunner().invoke(app, ["check", str(file), *how]) for how in ([], ["--update"], ["--update"])
    )
    assert [one.exit_code for one in (refused, done, again)] == [1, 0, 0]
    assert "Left out analysis.cutoff" in done.output
    assert "Nothing to update" in again.output
    gone = [line for line in OLD.splitlines() if not re.match("reduction|cutoff", line)]
    assert file.read_text().splitlines() == gone


def test_results_of_earlier_versions_state_what_said_nothing():
    assert Analysis.read({"reduction": "none", "cutoff": "auto", "stations": 7}).stations == 7
