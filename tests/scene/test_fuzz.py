"""Damaged scene files: each is a scene, or refused with one line; never anything else.

``FENICS_MECH_FUZZ=10000 pytest tests/scene/test_fuzz.py`` is the long run: so many files, and a twentieth as
many analysed.
"""

import os
import random
import signal
from contextlib import contextmanager

import numpy as np
import pytest

from fenics_mech import analyse
from fenics_mech.errors import MechanismError
from fenics_mech.machine.reach import reachable_range
from fenics_mech.recovery.measured import read_measurement
from fenics_mech.scene import Scene, parse
from fenics_mech.scene.drawing import completed
from fenics_mech.scene.factories import seed_four_bar
from fenics_mech.scene.plausibility import implausible
from fenics_mech.scene.solver_options import OPTIONS, takes
from tests.scene.mutation import damaged_bytes, damaged_data, damaged_options, damaged_text, data_of, drawings, scenes

FILES = int(os.environ.get("FENICS_MECH_FUZZ", "800"))
RUNS = max(FILES // 20, 30)
PATIENCE = 60  # seconds for a file: beyond it the program hangs
TEXTS = scenes()
SMALL = [name for name in TEXTS if name != "jansen"]  # which takes most of the time
EFFECTS = ((), ("coupling",), ("large-rotations",), ("geometric-stiffness",), ("lumped-mass",))


@contextmanager
def in_time():
    """Raise where something hangs."""

    def late(*_):
        raise TimeoutError(f"not refused or done within {PATIENCE} s")

    before = signal.signal(signal.SIGALRM, late)
    signal.alarm(PATIENCE)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


def attempt(work):
    """Give what some work gives, or the error of ours that it ends with, which must be one line."""
    with in_time():
        try:
            return work()
        except MechanismError as error:
            assert str(error).isprintable()  # noqa: PT017
            return error


@pytest.mark.parametrize("name", TEXTS)
def test_damaged_files_are_scenes_or_refused_in_one_line(name):
    text, data, good = TEXTS[name], data_of(TEXTS[name]), 0
    files = FILES // len(TEXTS)
    for k in range(files):
        chance = random.Random(f"{name}-{k}")
        if k % 2:
            found = attempt(lambda chance=chance: parse(damaged_text(text, chance), file="damaged.toml"))
        else:
            found = attempt(lambda chance=chance: Scene.read(damaged_data(data, chance)))
        if not isinstance(found, MechanismError):
            good += 1
            assert all(warning.isprintable() for warning in attempt(lambda scene=found: implausible(scene)))
            if FILES > 5000 and name != "manipulator":  # `fenics-mech check`, which takes its time
                attempt(lambda scene=found: reachable_range(scene))
    assert files / 50 < good < files / 2


def test_solver_options_are_listed_ones_or_refused():
    good = 0
    for k in range(FILES // 4):
        options = damaged_options(random.Random(f"options-{k}"))
        found = attempt(lambda options=options: seed_four_bar(petsc=options))
        if isinstance(found, MechanismError):
            assert str(found).startswith("petsc")
        else:
            good += 1
            assert all(takes(OPTIONS[key], value) for key, value in found.petsc.items())
    assert FILES / 200 < good < FILES / 6


def test_damaged_drawings_are_drawings_or_refused(tmp_path, monkeypatch, capfd):
    """Each is read by a process of its own, so that few are."""
    monkeypatch.chdir(tmp_path)
    contents = drawings()
    for k in range(max(FILES // 200, 6)):
        chance = random.Random(f"drawing-{k}")
        name = list(contents)[k % len(contents)]
        (tmp_path / name).write_bytes(damaged_bytes(contents[name], chance))
        data = {"drawing": {"file": name, "section": "bar", "material": "steel"}}
        attempt(lambda data=data: completed(data, tmp_path))
    assert {path.name for path in tmp_path.iterdir()} <= set(contents)
    assert capfd.readouterr() == ("", "")


def test_damaged_measurements_are_numbers_or_refused(tmp_path):
    rows = "".join(f"{angle},{1e-4 * np.sin(angle):.6e}\n" for angle in range(0, 360, 15))
    content, good = f"angle (deg),strain\n{rows}".encode(), 0
    for k in range(FILES // 4):
        (tmp_path / "coupler.csv").write_bytes(damaged_bytes(content, random.Random(f"measurement-{k}")))
        found = attempt(lambda: read_measurement(tmp_path / "coupler.csv"))
        if not isinstance(found, MechanismError):
            good += 1
            assert np.isfinite(found).all()
    assert FILES / 100 < good < FILES / 5


def damaged_scene(chance):
    """Give a scene of small size whose damage leaves it a scene."""
    data = data_of(TEXTS[chance.choice(SMALL)])
    while True:
        try:
            scene = Scene.read(damaged_data(data, chance))
            changes = {"sub_intervals": 24, "stations": 5, "harmonics": 5, "allow_ringing": True, "allow_coarse": True}
            changes = {f"analysis__{key}": value for key, value in changes.items()}
            return scene.changed(**changes, mesh={"elements": 2}, effects=chance.choice(("auto", *EFFECTS)))
        except MechanismError:
            continue


@pytest.mark.long
def test_damaged_scenes_have_finite_answers_or_an_error_of_ours():
    solved = 0
    for k in range(RUNS):
        scene = damaged_scene(random.Random(f"run-{k}"))
        found = attempt(lambda scene=scene: analyse(scene))
        if not isinstance(found, MechanismError):
            solved += 1
            assert np.isfinite(found.data["strain"]).all()
    assert solved > RUNS / 4
