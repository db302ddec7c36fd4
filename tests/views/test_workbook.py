"""The file for spreadsheets, opened by openpyxl: its numbers are those of the result, and no text is a formula."""

import json
import sys
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

from fenics_mech import Prismatic, Result, ResultError, Revolute, ViewError, write_workbook
from fenics_mech.cli import app
from fenics_mech.scene.answer_units import AnswerUnits
from fenics_mech.views import workbook
from fenics_mech.views.reading import reading_of
from fenics_mech.views.workbook import Sheet, sheets_of
from tests.views.test_page import free_result


def opened(path):
    """Rows of every sheet."""
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.load_workbook(path)
    return {sheet.title: list(sheet.iter_rows(values_only=True)) for sheet in book}


def column(rows, head):
    return np.array([row[rows[0].index(head)] for row in rows[1:]], dtype=float)


@pytest.fixture(scope="module")
def file(result, tmp_path_factory):
    pytest.importorskip("openpyxl")
    return write_workbook(result, tmp_path_factory.mktemp("books") / "result.xlsx")


def test_curves_are_those_of_the_result_in_its_units(result, file):
    """MPa, mm and N of the result in SI: float64 is written with 17 digits, so the numbers are equal."""
    found, data = opened(file), result.data
    coupler = data.sel(member="coupler").sel(s=0.5)
    assert column(found["stress"], "stress, coupler, s = 0.5, + (MPa)") == pytest.approx(
        coupler["stress"].sel(fibre="+").to_numpy() / 1e6, rel=1e-14
    )
    assert column(found["moment"], "moment, coupler, s = 0.5 (N m)") == pytest.approx(coupler["moment"].to_numpy())
    assert column(found["deflection"], "deflection, coupler, s = 0.5, y (mm)") == pytest.approx(
        1e3 * coupler["deflection"].sel(component="y").to_numpy(), rel=1e-14
    )
    force = column(found["joint curves"], "joint force, B, x (N)")
    assert force == pytest.approx(data["joint_force"].sel(joint="B", component="x").to_numpy(), rel=1e-14)
    assert column(found["joint curves"], "drive angle (deg)") == pytest.approx(np.degrees(data["theta"]))
    assert column(found["drive and frame curves"], "input torque (N m)") == pytest.approx(
        data["input_torque"].to_numpy()
    )
    assert column(found["frequency curves"], "frequency, 2 (Hz)") == pytest.approx(data["frequency"][:, 1].to_numpy())
    written = {head.partition(",")[0].partition(" (")[0] for rows in found.values() for head in map(str, rows[0])}
    over_theta = {str(name).replace("_", " ") for name in data.data_vars if "theta" in data[name].dims}
    assert over_theta <= written


def test_tables_are_those_of_the_summary(result, file):
    found, reading = opened(file), reading_of(result)
    first, peak = found["members"][1], reading.peaks[reading.ranked[0]]
    assert first[0] == reading.members[peak.i]
    assert first[1] == pytest.approx(reading.stress[peak.k, peak.i, peak.j, peak.f], rel=1e-14)
    assert first[6] == pytest.approx(np.degrees(reading.theta[peak.k]) % 360)
    moments = {row[0]: row[found["members"][0].index("largest bending moment (N m)")] for row in found["members"][1:]}
    for member, moment in moments.items():
        known = result.data["moment"].sel(member=member)
        assert abs(moment) >= float(abs(known).max()) - 1e-12  # the curves reach their peaks between the positions
        assert abs(moment) == pytest.approx(float(abs(known).max()), rel=0.05)
    frame = found["joints"][-1]
    assert frame[0] == "on the frame"
    assert np.hypot(frame[2], frame[3]) == pytest.approx(frame[1])
    assert frame[1] == pytest.approx(np.linalg.norm(reading.shaking[0], axis=1).max())
    errors = found["errors"]
    assert [row[0] for row in errors[1:]] == reading.members
    wrong = result.data["strain_error"].sel(member="crank").sum() / result.data["largest_strain"].sel(member="crank")
    assert errors[1][-1] == pytest.approx(100 * float(wrong))
    lowest = column(found["frequencies"], "lowest (Hz)")
    assert lowest == pytest.approx(result.data["frequency"].min("theta").to_numpy())
    said = dict(row[:2] for row in found["summary"] if row[0])
    assert said["machine"] == result.scene.name
    assert said["found"].startswith("Peak stress")
    ranges = [row for row in found["values"] if row[0] == "stress range" and row[1] == "crank, s = 0, +"]
    assert ranges[0][2] == pytest.approx(float(result.data["stress_range"].sel(member="crank", fibre="+")[0]) / 1e6)


@pytest.mark.parametrize("name", ["=1+1", "+1", "-1", "@SUM(A1)", "=cmd|' /C calc'!A0"])
def test_no_name_of_a_stranger_is_a_formula(result, tmp_path, name):
    openpyxl = pytest.importorskip("openpyxl")
    scene = json.loads(result.data.attrs["scene"]) | {"name": name}
    data = result.data.assign_coords(joint=[name, "A", "B", "C"]).assign_attrs(scene=json.dumps(scene))
    data.attrs["warnings"] = json.dumps([name])
    book = openpyxl.load_workbook(write_workbook(Result(data), tmp_path / "hostile.xlsx"))
    kinds = {cell.data_type for sheet in book for row in sheet.iter_rows() for cell in row}
    assert kinds <= {"s", "n", "inlineStr"}
    cells = [cell for row in book["joints"].iter_rows() for cell in row if cell.column == 1]
    (taken,) = [cell for cell in cells if cell.value == name]
    assert taken.quotePrefix  # a spreadsheet makes no formula of it where it is edited


def test_characters_that_no_file_can_hold_are_replaced(result, tmp_path):
    pytest.importorskip("openpyxl")
    data = result.data.assign_coords(joint=["a\x01b", "A", "B", "C"])
    found = opened(write_workbook(Result(data), tmp_path / "odd.xlsx"))
    assert "a\N{REPLACEMENT CHARACTER}b" in [row[0] for row in found["joints"]]


def test_units_that_are_named_and_one_position_of_some(result, tmp_path):
    pytest.importorskip("openpyxl")
    result.save(tmp_path / "result.nc")
    words = ["export", str(tmp_path / "result.nc"), str(tmp_path / "out.xlsx"), "--units", "psi, lbf", "--every", "6"]
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 0, done.output
    found = opened(tmp_path / "out.xlsx")
    psi = column(found["stress"], "stress, crank, s = 0, + (psi)")
    known = result.data["stress"].sel(member="crank", fibre="+")[::6, 0]
    assert psi == pytest.approx(known.to_numpy() / 6894.757293168361)  # lbf/in^2: 4.4482216152605 N over 0.0254^2 m^2
    assert "largest force (lbf)" in found["joints"][0]


def test_a_motion_in_time_and_mixed_units(tmp_path):
    pytest.importorskip("openpyxl")
    result = free_result()
    found = opened(write_workbook(result, tmp_path / "free.xlsx"))
    rows = next(rows for rows in found.values() if rows[0] and str(rows[0][0]) == "time (s)")
    assert column(rows, "time (s)") == pytest.approx(result.data["time"].to_numpy())


@pytest.mark.parametrize(("joint", "unit", "size"), [("turns", "rad", 1.0), ("slides", "mm", 1e-3)])
def test_freedoms_that_slide_are_told_in_mm_and_those_that_turn_in_rad(joint, unit, size):
    """The unit of the variable is that of an angle."""
    kinds = {"turns": Revolute(connect=("ground.O", "a.O")), "slides": Prismatic(connect=("ground.O", "a.O"))}
    place = xr.DataArray([[1.0]], {"freedom": [joint]}, ("theta", "freedom"), "freedom_place", {"units": "rad"})
    told = workbook._units(SimpleNamespace(scene=SimpleNamespace(joints=kinds), units=AnswerUnits()), place)
    assert told == ([unit], size)


def test_nothing_is_written_where_it_cannot(result, tmp_path, monkeypatch):
    with pytest.raises(ViewError, match=r"must end in \.xlsx"):
        write_workbook(result, tmp_path / "result.ods")
    with pytest.raises(ResultError, match="1 or more"):
        write_workbook(result, tmp_path / "result.xlsx", every=0)
    monkeypatch.setattr(workbook, "MOST_CELLS", 1000)
    with pytest.raises(ViewError, match=r"takes 1000: write one position of \d+ with --every"):
        write_workbook(result, tmp_path / "result.xlsx")
    monkeypatch.undo()
    monkeypatch.setitem(sys.modules, "openpyxl", None)
    with pytest.raises(ViewError, match=r"openpyxl.*pip install 'fenics_mech\[tables\]'"):
        write_workbook(result, tmp_path / "result.xlsx")
    assert not list(tmp_path.iterdir())


def test_the_advice_on_size_is_enough(result, monkeypatch):
    """With the step that the message names, the file is written."""
    monkeypatch.setattr(workbook, "MOST_CELLS", 5000)
    with pytest.raises(ViewError) as error:
        sheets_of(result)
    every = int(str(error.value).partition("one position of ")[2].partition(" ")[0])
    assert all(isinstance(sheet, Sheet) for sheet in sheets_of(result, every))
