"""What a run prints fits a screen, and its first lines answer: how large, where, and may the number be used."""

import json

import numpy as np
import pytest

from fenics_mech import analyse, load
from fenics_mech.recovery import Result
from fenics_mech.views.judgements import headline, judgements, verdict
from fenics_mech.views.reading import Reading
from fenics_mech.views.safety_words import safety_sentences
from fenics_mech.views.summary import MOST_MEMBERS, summary
from fenics_mech.views.words import short
from tests.common import DEMOS, analysed

LINES, WIDTH = 31, 80  # and one for what was written


def lines(result, monkeypatch):
    monkeypatch.setenv("COLUMNS", str(WIDTH))
    found = [line.rstrip() for line in str(summary(result)).splitlines()]
    assert max(map(len, found)) <= WIDTH
    return found


def test_the_first_lines_are_machine_peak_and_verdict(result, monkeypatch):
    machine, *rest = lines(result, monkeypatch)
    assert machine == "seed four-bar: drive O at 32.3 rad/s (308 rpm), one turn in 0.195 s"
    safe = " ".join(safety_sentences(result, Reading(result).units)[1])
    peak = " ".join(headline(Reading(result)))
    assert " ".join(rest).startswith(f"{safe} {peak} {verdict(judgements(result))[1]}")


def test_gravity_that_is_not_stated_is_no_finding(result):
    assert "gravity (none is stated)" in str(summary(by_choice(result, {})))
    heavy = {"gravity": [0, "-9.81 m/s^2"]}
    assert "gravity \N{LESS-THAN OR EQUAL TO} 42 %" in str(summary(by_choice(result, heavy)))


def by_choice(result, more):
    """The result, as if its effects had been chosen in a scene with more."""
    listed = [{"name": "gravity", "acts": False, "size": 0.42 if more else 0.0, "lacking": ""}]
    scene = result.scene.changed(more)
    return Result(result.data.assign_attrs(effects=json.dumps(listed), scene=scene.model_dump_json()))


def test_reasons_against_the_numbers_come_before_the_tables(result, monkeypatch):
    text = " ".join(" ".join(lines(result, monkeypatch)).split())
    for judged in judgements(result):
        if judged.level == "good" and judged.about != "error":  # which the sentence of accuracy and --details tell
            continue
        assert (text.index(judged.text) < text.index("stress strain")) == (judged.level in ("bad", "warn"))


def test_members_are_sorted_by_stress_and_joints_stand_side_by_side(result, monkeypatch):
    found = lines(result, monkeypatch)
    reading = Reading(result)
    start = next(i for i, line in enumerate(found) if line.startswith("member "))
    assert [line.split()[0] for line in found[start + 1 : start + 4]] == [reading.members[i] for i in reading.ranked]
    head, force = (next(line.split() for line in found if line.startswith(name)) for name in ("joint", "force, N"))
    assert head[1:] == ["O", "A", "B", "C"]
    assert force[2:] == [short(float(value)) for value in reading.force.max(axis=0)]
    torque = next(line for line in found if line.startswith("drive torque"))
    k = int(np.abs(reading.effort).argmax())
    assert torque.split("  ")[-1].split(";")[0] == f"{short(float(reading.effort[k]))} N m at {reading.at(k)}"


LONG = pytest.param("quick_return", marks=pytest.mark.xfail(reason="34 lines"))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["four_bar", "slider_crank", "stephenson", "watt", LONG])
def test_machines_of_up_to_five_links_fit_a_screen(name, monkeypatch):
    assert len(lines(analysed(load(DEMOS / f"{name}.toml")), monkeypatch)) <= LINES


@pytest.mark.slow
def test_of_many_members_and_joints_the_largest_are_shown(monkeypatch):
    result = analysed(load(DEMOS / "jansen.toml"))
    found, reading = lines(result, monkeypatch), Reading(result)
    start = next(i for i, line in enumerate(found) if line.startswith("member"))
    shown = [line.split()[0] for line in found[start + 1 : start + 1 + MOST_MEMBERS]]
    assert shown == [reading.members[i] for i in reading.ranked[:MOST_MEMBERS]]
    assert found[start + 1 + MOST_MEMBERS].startswith(f"and {21 - MOST_MEMBERS} more, none above ")
    assert "the largest of 19 joints" in found


def test_warnings_are_counted_and_results_without_vibration_have_fewer_rows(result, monkeypatch):
    warned = Result(result.data.assign_attrs(warnings=json.dumps([f"number {i}" for i in range(5)])))
    text = "\n".join(lines(warned, monkeypatch))
    assert text.count("Warning: number") == 3
    assert "2 more warnings: see --details" in text
    scene = result.scene.changed(analysis__method="quasi-static", analysis__sub_intervals=24)
    still = "\n".join(lines(analyse(scene), monkeypatch))
    assert "vibrates" not in still
    assert "frequencies" in still  # of the few positions at which critical speeds are sought
