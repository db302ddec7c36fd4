"""Damaged scene files: each is a scene, or refused with one line; never anything else."""

import random
import re
from pathlib import Path

import numpy as np
import pytest

from fenics_mech import analyse
from fenics_mech.errors import MechanismError, SceneError
from fenics_mech.scene import parse

DEMOS = Path(__file__).parents[2] / "demos"
VALUES = '0 -1 1e308 1e-300 nan inf "" "x" [] {} true "1_kg" "1_m" "-5_deg" [1,2,3] "ground.O" 99999999999 "slot" "é"'
TOKEN = re.compile(r'"[^"]*"|\b[\d.]+(e-?\d+)?\b|\b[A-Za-z_]\w*\b')


def damaged(text, chance):
    """Delete a line, repeat one, or put something odd in a place of one."""
    lines = text.split("\n")
    for _ in range(chance.choice([1, 1, 2])):
        i, kind = chance.randrange(len(lines)), chance.random()
        places = list(TOKEN.finditer(lines[i].split("#")[0]))
        if kind < 0.15:
            del lines[i]
        elif kind < 0.25:
            lines.insert(i, chance.choice(lines))
        elif places:
            place, value = chance.choice(places), chance.choice(VALUES.split()).replace("_", " ")
            lines[i] = lines[i][: place.start()] + value + lines[i][place.end() :]
    return "\n".join(lines)


@pytest.mark.parametrize("name", ["four_bar", "slider_crank", "quick_return", "manipulator", "composite_four_bar"])
def test_damaged_files_are_scenes_or_refused_in_one_line(name):
    text, chance = (DEMOS / f"{name}.toml").read_text(), random.Random(1989)
    good = refused = 0
    for _ in range(400):
        try:
            parse(damaged(text, chance), file="damaged.toml")
            good += 1
        except SceneError as error:
            assert "\n" not in str(error)  # noqa: PT017
            refused += 1
    assert good > 20
    assert refused > 200


def test_damaged_scenes_have_finite_answers_or_an_error_of_ours():
    text, chance = (DEMOS / "four_bar.toml").read_text(), random.Random(7)
    solved = 0
    for _ in range(150):
        try:
            scene = parse(damaged(text, chance))
            if scene.mesh.elements > 50:
                continue
            strain = analyse(
                scene.changed(analysis__sub_intervals=24, analysis__allow_ringing=True, analysis__allow_coarse=True)
            ).data["strain"]
        except MechanismError:
            continue
        solved += 1
        assert np.isfinite(strain).all()
    assert solved > 20
