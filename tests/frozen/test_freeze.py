"""The comparison with frozen answers: three scenes meet theirs, and what is changed is found."""

from dataclasses import replace

import numpy as np
import pytest

from tests.frozen import freeze

FAST = "four_bar_06_quasi_static", "slider_crank_06_static", "laws_04_auto"


@pytest.fixture(scope="module")
def frozen():
    return freeze.read()


@pytest.fixture(scope="module")
def present():
    return {name: freeze.answer_to(name) for name in FAST}


def test_every_scene_is_frozen(frozen):
    assert sorted(frozen) == sorted(path.stem for path in freeze.SCENES.glob("*.toml"))
    assert all("error" in answer.texts or answer.numbers for answer in frozen.values())


@pytest.mark.parametrize("name", FAST)
def test_the_present_answers_are_the_frozen_ones(name, frozen, present):
    """To the errors that are told, and on the machine that froze them to the last bit."""
    found = list(freeze.differences(name, frozen[name], present[name]))
    assert len(found) > 20
    assert [one for one in found if not one.ratio <= 1] == []


@pytest.mark.parametrize("name", FAST)
def test_answers_come_back_as_they_were_kept(name, present):
    back = freeze.unpacked(**freeze.packed(present[name]))
    assert back.texts == present[name].texts
    assert back.marks == present[name].marks
    for variable, values in present[name].numbers.items():
        np.testing.assert_allclose(back.numbers[variable], values, rtol=2**-27, err_msg=variable)  # 26 bits are kept


def compared(monkeypatch, capsys, name, answer):
    """Run the command on one scene whose answer is made up, and give its exit code and what it prints."""
    monkeypatch.setattr(freeze, "answers", lambda names, jobs: ((one, answer) for one in names))
    code = freeze.main(["compare", name])
    return code, capsys.readouterr().out


@pytest.mark.parametrize("variable", ["strain", "strain peak", "joint_force", "position", "input_torque"])
def test_a_changed_number_is_found(variable, monkeypatch, capsys, present):
    """One number differs by four times the told error of its variable, and none by a quarter of it."""
    name, base = FAST[0], variable.removesuffix(freeze.PEAK)
    numbers = present[name].numbers
    size = freeze.size_of(numbers[base + freeze.PEAK])
    step = size * freeze.told(numbers, present[name].texts, base, size)
    for share, code in ((0.25, 0), (4, 1)):
        changed = numbers[variable].copy()
        changed.flat[np.nanargmax(np.abs(changed))] += share * step
        answer = replace(present[name], numbers=numbers | {variable: changed})
        found, said = compared(monkeypatch, capsys, name, answer)
        assert found == code, said
        assert (f"{name:34} {base:28}" in said) == (code == 1)


def test_what_is_missing_or_ends_otherwise_is_found(monkeypatch, capsys, present):
    name = FAST[0]
    numbers = {key: values for key, values in present[name].numbers.items() if not key.startswith("moment")}
    code, said = compared(monkeypatch, capsys, name, replace(present[name], numbers=numbers))
    assert (code, "moment " in said, "inf" in said) == (1, True, True)
    code, said = compared(monkeypatch, capsys, name, freeze.Answer(texts={"error": "SolverError: it buckles"}))
    assert (code, "'an answer' has become 'SolverError: it buckles'" in said) == (1, True)


def test_other_positions_leave_the_peaks_to_be_compared(monkeypatch, capsys, present):
    name = FAST[0]
    numbers = dict(present[name].numbers)
    numbers["theta"] = numbers["theta"] + 0.01
    numbers["strain"] = 1.5 * numbers["strain"]
    code, said = compared(monkeypatch, capsys, name, replace(present[name], numbers=numbers))
    assert code == 0, said
    numbers["strain" + freeze.PEAK] = 1.5 * numbers["strain" + freeze.PEAK]
    code, said = compared(monkeypatch, capsys, name, replace(present[name], numbers=numbers))
    assert (code, "peaks alone, at other positions" in said) == (1, True)
