"""How a run grows: the chain of four-bars, how runs are measured, and what is made of them."""

import io
import os
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console
from typer.testing import CliRunner

from benchmarks import scaling as study
from benchmarks import timing
from benchmarks.__main__ import app
from benchmarks.scaling import (
    LONGEST_LINE_RUN,
    PER_POSITION,
    SOLVERS,
    Scaling,
    Size,
    chain,
    cost_per_position,
    in_own_process,
    measure_scaling,
    peak_memory,
    sizes,
)
from benchmarks.scaling_plots import SERIES, last_power, scaling_figure, scaling_summary, write_scaling
from fenics_mech.errors import MechanismError, ResultError, SolverError
from fenics_mech.machine.linkage import solve_motion

LAW = {"elements": 1e-3, "links": 2e-2, "positions": 5e-4}  # s per each


def linear(size):
    """A run that takes some time for each element, link and position, and more for elements if positions are there."""
    seconds = sum(rate * getattr(size, name) for name, rate in LAW.items())
    return {"seconds": seconds, "wall_seconds": seconds, "repeats": 1.0, "memory": 200.0, "memory_before": 100.0}


@pytest.fixture(scope="module")
def quick():
    """The quick sizes, as if they had been run."""
    return measure_scaling(sizes(quick=True), run=linear)


def test_stages_of_the_chain_are_parallelograms():
    # so every follower turns like the first, and the couplers after the first do not turn
    scene = chain(4)
    assert len(scene.links) == 9
    motion = solve_motion(scene, scene.drive_angles(12))
    angle = dict(zip(motion.links, motion.angle.T))
    for stage in (2, 3, 4):
        assert np.allclose(angle[f"follower{stage}"], angle["follower"], atol=1e-12)
        assert np.allclose(angle[f"coupler{stage}"], 0, atol=1e-12)
    stiff = [scene.sections[scene.links[name].members["AB"].section].inertia for name in ("coupler", "coupler4")]
    assert stiff[1] / stiff[0] == pytest.approx(1.03**3)


def test_lines_grow_and_reach_what_they_should():
    asked = sizes()
    for series in SERIES:
        for line in {size.line for size in asked if size.series == series}:
            along = [getattr(size, series) for size in asked if size.line == line]
            assert along == sorted(set(along))
    assert max(size.elements for size in asked) == 300  # more are refused
    assert (max(size.links for size in asked), max(size.positions for size in asked)) == (29, 10_000)


def test_scenes_are_as_large_as_asked():
    scene = Size("links", "collocation", elements=5, links=9, positions=77).scene()
    assert (len(scene.links), scene.mesh.elements, scene.analysis.sub_intervals) == (9, 5, 77)
    assert scene.analysis.solver == "collocation"
    assert scene.effects == SOLVERS["collocation"]


def test_a_line_ends_after_a_long_run_and_errors_are_kept():
    def run(size):
        if size.links == 5:
            raise SolverError("no answer")
        return linear(size) | {"seconds": 1.1 * LONGEST_LINE_RUN if size.links == 7 else 0.1}

    line = [Size("links", "collocation", links=links) for links in (3, 5, 7, 9)]
    data = measure_scaling([*line, Size("links", "sub-intervals", links=9)], run=run).data
    assert data["failure"].to_numpy().tolist() == ["", "SolverError", "", "TimeoutError", ""]
    assert np.isfinite(data["seconds"]).to_numpy().tolist() == [True, False, True, False, True]
    assert str(data["message"][1].item()) == "no answer"


def test_cost_of_a_position_leaves_out_what_is_done_once(quick):
    found = cost_per_position(quick.data)
    assert [(solver, elements) for solver, elements, _ in found] == [(s, e) for s in SOLVERS for e in (8, 32)]
    assert np.allclose([seconds for *_, seconds in found], LAW["positions"])


def test_powers_are_those_of_the_last_two_known_values():
    numbers = np.array([100.0, 1.0, 8.0, np.nan])
    assert last_power(np.array([1, 2, 4, 8]), numbers) == pytest.approx(3)
    assert np.isnan(last_power(np.array([1, 2]), np.array([1.0, np.nan])))


class Fatal(Size):
    """A size that the system ends the process over."""

    def scene(self):
        os._exit(9)


@pytest.mark.slow
def test_a_run_has_the_memory_of_its_own_process():
    ballast = np.ones(60_000_000)  # 480 MB
    found = in_own_process(Size("elements", "sub-intervals", positions=60))
    assert peak_memory() > ballast.nbytes / 1e6
    assert 50 < found["memory_before"] <= found["memory"] < ballast.nbytes / 1e6
    assert found["seconds"] > 0


@pytest.mark.slow
def test_a_process_that_is_ended_is_an_error():
    with pytest.raises(MechanismError, match="too little memory"):
        in_own_process(Fatal("elements", "sub-intervals"))


def test_table_and_figure_are_written_whole(quick, tmp_path):
    written = write_scaling(quick, tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["scaling.csv", "scaling.nc", "scaling.png"]
    assert Scaling.load(tmp_path / "scaling.nc").data.identical(quick.data)
    lines = written[0].read_text().splitlines()
    assert len(lines) == 1 + quick.data.sizes["run"]
    assert "memory (MB)" in lines[0]
    (tmp_path / "scaling.nc").write_bytes(b"nothing")
    with pytest.raises(ResultError, match="not a table of sizes"):
        Scaling.load(tmp_path / "scaling.nc")


def test_figure_draws_time_and_memory_over_each_size(quick):
    figure = scaling_figure(quick)
    assert len(figure.axes) == 6
    for axes in figure.axes:
        assert axes.get_xscale() == axes.get_yscale() == "log"
        assert len(axes.lines) == 2  # solvers
    drawn = figure.axes[2].lines[0].get_xdata()
    assert np.array_equal(drawn, [60, 400])


def test_command_writes_its_files_and_says_what_it_found(quick, monkeypatch, tmp_path):
    monkeypatch.setattr(study, "in_own_process", linear)
    found = CliRunner().invoke(app, ["scaling", "--quick", "-o", str(tmp_path / "out")])
    assert found.exit_code == 0
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"scaling.csv", "scaling.nc", "scaling.png"}
    console = Console(file=io.StringIO(), width=200)
    console.print(scaling_summary(quick))
    said = console.file.getvalue()
    assert said.count("exponent of growth") == 3
    assert "Time per position" in said
    assert PER_POSITION in quick.data["series"].to_numpy()


def test_memory_is_told_where_there_is_no_proc(monkeypatch):
    here = peak_memory()
    monkeypatch.setattr(timing, "Path", lambda path: Path("/none") / path.lstrip("/"))
    kept = peak_memory() * 1024  # here Linux gives kB; macOS gives bytes
    assert 0.9 * here < kept  # that of the program that started this one may be larger
