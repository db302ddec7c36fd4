"""Processes of this machine that share work: each task once, and one that is killed costs its task."""

import contextlib
import logging
import os
import re
import signal
import subprocess
import time
from functools import partial
from pathlib import Path

import pytest

from fenics_mech import load
from fenics_mech.errors import SolverError
from fenics_mech.studies.sweep import Sweep, sweep
from fenics_mech.studies.sweep_axes import parse_axes
from fenics_mech.studies.worker_processes import Workers
from tests.studies.processes import ENVIRONMENT, command, finished
from tests.studies.test_sweep import ARM, RANGE

POINTS = 12
OVER = RANGE.replace(":16", f":{POINTS}")


def alone(count):
    """So many tasks, of which none follows another."""
    return [[task] for task in range(count)]


def shared(count, *arguments):
    """Let so many processes work on tasks, and end."""
    with Workers(count) as workers:
        workers.share(*arguments)


def write(folder, task):
    """Write the process that a task is worked on by."""
    (folder / str(task)).write_text(str(os.getpid()))


def write_or_die(folder, task):
    if task == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    write(folder, task)


def fail(task):
    raise SolverError("no answer")


def test_each_task_is_done_once_by_one_of_the_processes(tmp_path):
    begun = []
    shared(2, alone(8), partial(write, tmp_path), pytest.fail, begun.append)
    found = [path.read_text() for path in sorted(tmp_path.iterdir())]
    assert len(found) == 8
    assert 1 <= len(set(found)) <= 2
    assert str(os.getpid()) not in found
    assert begun == list(range(8))


def ended(process):
    """Whether a process ends in time."""
    limit = time.monotonic() + 20
    while time.monotonic() < limit and Path(f"/proc/{process}").exists():
        time.sleep(0.05)
    return not Path(f"/proc/{process}").exists()


def test_processes_work_on_until_the_study_ends(tmp_path):
    """From one call to the next, but for one that is lost in between."""
    by = []
    with Workers(2) as workers:
        for name in "abc":
            (tmp_path / name).mkdir()
            workers.share(alone(8), partial(write, tmp_path / name), pytest.fail)
            by.append({int(path.read_text()) for path in (tmp_path / name).iterdir()})
            if name == "b":
                os.kill(lost := min(by[1]), signal.SIGKILL)
                assert ended(lost)
                time.sleep(0.5)  # until it is known here too
    assert by[1] <= by[0]
    assert lost not in by[2]
    assert all(map(ended, set().union(*by)))


def test_a_process_that_is_killed_costs_its_task(tmp_path):
    lost = []
    shared(2, alone(8), partial(write_or_die, tmp_path), lost.append)
    assert lost == [3]
    assert sorted(int(path.name) for path in tmp_path.iterdir()) == [0, 1, 2, 4, 5, 6, 7]


def test_one_process_works_on_a_run_and_another_goes_on_where_it_is_killed(tmp_path):
    lost = []
    shared(2, [range(3), range(3, 6), range(6, 8)], partial(write_or_die, tmp_path), lost.append)
    assert lost == [3]
    by = {int(path.name): path.read_text() for path in tmp_path.iterdir()}
    assert sorted(by) == [0, 1, 2, 4, 5, 6, 7]
    for run in ([0, 1, 2], [4, 5], [6, 7]):
        assert len({by[task] for task in run}) == 1


def log_or_die(task):
    log = logging.getLogger("fenics_mech.somewhere")
    log.debug("too quiet")
    log.info("task %d", task)
    if task == 2:
        os.kill(os.getpid(), signal.SIGKILL)


def test_what_processes_log_is_told_here(caplog):
    caplog.set_level(logging.INFO, "fenics_mech")
    shared(2, alone(6), log_or_die, lambda task: None)
    told = [record.getMessage() for record in caplog.records if record.name == "fenics_mech.somewhere"]
    assert sorted(told) == [f"task {n}" for n in range(6)]


def tell_holders(file):
    """Write which process starts others, and who holds the socket at which it is asked to."""
    starter = os.getppid()
    asked = re.findall(r"main\((\d+),", Path(f"/proc/{starter}/cmdline").read_text())[0]
    socket = link_of(f"/proc/{starter}/fd/{asked}")
    holders = {path.parts[2] for path in Path("/proc").glob("[0-9]*/fd/*") if link_of(path) == socket}
    Path(file).write_text(f"{starter} {' '.join(holders)}")


def link_of(path):
    try:
        return os.readlink(path)
    except OSError:  # its process has ended, or is another user's
        return ""


@pytest.mark.slow
def test_no_daemon_of_mpi_keeps_the_socket_at_which_processes_are_asked_for(tmp_path):
    """Else who asks a process for another one that is lost in between waits for ever."""
    work = "from tests.studies.test_worker_processes import shared, tell_holders"
    ended = finished("-c", f"{work}; shared(1, [[{str(tmp_path / 'holders')!r}]], tell_holders, print)")
    assert ended.returncode == 0, ended.stderr
    starter, *holders = (tmp_path / "holders").read_text().split()
    assert holders == [starter]


def end_the_starter(task):
    os.kill(os.getppid(), signal.SIGKILL)
    time.sleep(10)  # a task that is done at once may be told so first


@pytest.mark.slow
def test_the_loss_of_the_process_that_starts_the_others_costs_their_tasks():
    lost = []
    shared(2, alone(4), end_the_starter, lost.append)
    assert set(lost) <= set(range(4))
    assert lost


def test_a_process_that_mpirun_started_starts_no_others(monkeypatch):
    monkeypatch.setenv("OMPI_COMM_WORLD_SIZE", "1")
    with pytest.raises(SolverError, match="leave one of them out"), Workers(2) as workers:
        workers.share([[1]], print, print)


def test_an_error_of_a_task_ends_all():
    with pytest.raises(SolverError, match="no answer"):
        shared(2, alone(8), fail, pytest.fail)


def python_children(process):
    """Processes that a process has begun, without the daemons of MPI."""
    with contextlib.suppress(OSError):
        found = Path(f"/proc/{process}/task/{process}/children").read_text().split()
        return [int(each) for each in found if "multiprocessing" in Path(f"/proc/{each}/cmdline").read_text()]
    return []


def workers_of(process):
    """Processes that a sweep works with: a daemon of MPI looks like one until it runs its own command."""
    found = [worker for child in python_children(process) for worker in python_children(child)]
    time.sleep(0.1)
    return [worker for child in python_children(process) for worker in python_children(child) if worker in found]


@pytest.mark.slow
def test_a_killed_worker_costs_its_point_and_the_next_sweep_computes_it(tmp_path):
    (tmp_path / "arm.toml").write_text(ARM)
    scene, folder = load(tmp_path / "arm.toml"), tmp_path / "shared"
    axes = parse_axes(scene, [OVER])
    whole = sweep(scene, axes, tmp_path / "whole")
    arguments = ("-m", "fenics_mech", "sweep", tmp_path / "arm.toml", "--over", OVER, "--jobs", 2, "-o", folder)
    with subprocess.Popen(command(*arguments), env=ENVIRONMENT, stdout=subprocess.PIPE, text=True) as process:
        limit, workers = time.monotonic() + 60, []
        while not workers and time.monotonic() < limit:
            workers = workers_of(process.pid)
        os.kill(workers[0], signal.SIGKILL)
        said, _ = process.communicate(timeout=120)
    assert process.returncode == 0
    found = Sweep.load(folder / "sweep.nc").data
    errors = found["error"].to_numpy()
    assert sorted(errors)[-2:] == ["", "LostProcess"]
    place = float(found["drive.period"][list(errors).index("LostProcess")])
    assert f"1 at drive.period = {place:.4g}"[:28] in " ".join(said.split())
    assert "the process was lost" in " ".join(said.split())
    again = sweep(scene, axes, folder)
    assert again.data.identical(whole.data)
