"""What the commands say and where they write: two consoles, a log, a progress bar, folders."""

from __future__ import annotations

import codecs
import gc
import io
import json
import logging
import math
import os
import signal
import sys
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import chdir, contextmanager, suppress
from pathlib import Path

from rich.console import Console, ConsoleOptions, RenderableType
from rich.markup import escape
from rich.progress import BarColumn, Progress, SpinnerColumn, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.segment import Segment

from fenics_mech._libraries import alone, leave_pint_out
from fenics_mech._progress import heard
from fenics_mech._system import memory_limit
from fenics_mech.errors import MechanismError, printable

LEAST_MEMORY = 800_000_000  # bytes of addresses: `run` of one bar has 640 million; with less, libraries hang or crash
PAUSE = 5  # seconds between two lines of progress
OFTEN = 0.05  # seconds between two pictures of a bar
LEAST_SHARE = 0.05  # of a motion, by which the time that it took is divided at least
PAGE_WIDTH = 90  # columns of a text on a page
PAGE = '<pre style="white-space:pre;overflow-x:auto;line-height:normal;font-family:monospace">{code}</pre>'


class _Console(Console):
    """A console whose texts, which files and libraries have a part in, hold no commands to the terminal."""

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterator[Segment]:
        for segment in super().render(renderable, options):
            if segment.control or segment.text.isprintable():
                yield segment
            else:
                yield Segment("\n".join(map(printable, segment.text.split("\n"))), segment.style)


PLAIN = {"\N{DEGREE SIGN}": " deg", "\N{MINUS SIGN}": "-", "\N{MICRO SIGN}": "u", "\N{GREEK SMALL LETTER MU}": "u"}


def _in_plain_letters(error: UnicodeError) -> tuple[str, int]:
    """Give what stands for characters that the encoding of the output lacks."""
    assert isinstance(error, UnicodeEncodeError)
    lacking = error.object[error.start : error.end]
    return "".join(PLAIN.get(letter, "?") for letter in lacking), error.end


def print_in_any_encoding() -> None:
    """Let what the system's encoding of the output lacks be told in plain letters: it may have no degree sign."""
    codecs.register_error("plain letters", _in_plain_letters)
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="plain letters")


out, err = _Console(emoji=False), _Console(stderr=True, emoji=False)
_made: list[Path] = []  # folders that this command has made, the outermost first


class _LogOnTerminal(logging.Handler):
    """Prints on stderr above the progress bar, without commands to the terminal."""

    def emit(self, record: logging.LogRecord) -> None:
        err.print(self.format(record), style="dim", highlight=False, markup=False, soft_wrap=True)


def log_to_terminal(verbose: bool) -> None:
    """Print warnings that the modules log on stderr; `verbose` prints all, with the time and the module's name."""
    logger, handler = logging.getLogger("fenics_mech"), _LogOnTerminal()
    line = "%(asctime)s %(name)s: %(message)s" if verbose else "warning: %(message)s"
    handler.setFormatter(logging.Formatter(line, "%H:%M:%S"))
    logger.handlers, logger.propagate = [handler], False
    logger.setLevel(logging.DEBUG if verbose else logging.WARNING)


@contextmanager
def loading() -> Iterator[None]:
    """Load modules, or make what else stays to the end, without a search for garbage in them, now or later."""
    gc.disable()
    try:
        yield
    finally:
        gc.freeze()
        gc.enable()


def start_libraries(solver: bool = True) -> None:
    """Start PETSc and Matplotlib without the options that they read from files in the current folder."""
    # A scene may lie in a folder from a stranger, and such options run programs. MPI and xarray start without what
    # the command does not use. Figures are files of one look: no settings of Matplotlib count, which may ask for
    # LaTeX.
    if (limit := memory_limit() or LEAST_MEMORY) < LEAST_MEMORY:
        raise MechanismError(
            f"a process may have {limit / 1e9:.2g} GB of memory here, and the libraries take {LEAST_MEMORY / 1e9:.2g}: "
            "raise the limit (ulimit -v)"
        )
    os.environ |= {"MPLBACKEND": "agg", "MATPLOTLIBRC": os.devnull}
    with loading(), chdir(os.sep), alone():
        import matplotlib  # noqa: F401, PLC0415

        from fenics_mech import _petsc  # noqa: PLC0415
    with loading():
        leave_pint_out()
    if hasattr(signal, "SIGPIPE"):  # PETSc ends the process where `head` has read enough; Python says it by an error
        signal.signal(signal.SIGPIPE, signal.SIG_IGN)
    if solver and isinstance(_petsc.PETSc, _petsc.Absent):
        raise _petsc.not_there(_petsc.PETSc.error)


def one_voice() -> bool:
    """Let the first process of `mpirun` speak only, and tell whether this one is it."""
    from fenics_mech._petsc import MPI  # noqa: PLC0415  (not for --help)

    first = bool(MPI.COMM_WORLD.rank == 0)
    out.quiet = err.quiet = not first
    return first


def text_of(what: RenderableType) -> str:
    """Give what the console shows of something, without colours."""
    plain = _Console(color_system=None, emoji=False)
    with plain.capture() as shown:
        plain.print(what)
    return shown.get()


def html_of(what: RenderableType) -> str:
    """Give what the console shows of something as HTML, with its colours, for 90 columns."""
    # Texts in it are escaped, as they may come from a stranger's file.
    kept = _Console(file=io.StringIO(), record=True, width=PAGE_WIDTH, emoji=False, force_jupyter=False)
    kept.print(what, highlight=False)
    return kept.export_html(inline_styles=True, code_format=PAGE)


@contextmanager
def progress_bar(total: int, alike: bool = True, quiet: bool = False) -> Iterator:
    """Show a progress bar with the time left, or where there is no terminal a line now and then; `quiet` shows none."""
    # Gives what names the next step. The time left is known once some steps are done, where all are `alike`, and in a
    # step that says how far it has come.
    columns = [SpinnerColumn(), TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn()]
    columns += [TextColumn("left:"), TimeRemainingColumn()] if alike else []
    with Progress(*columns, console=err, transient=True, disable=quiet or not err.is_terminal) as progress:
        bar = _Bar(progress, total, alike, spoken=math.inf if quiet or err.is_terminal else time.monotonic())
        with heard(bar.inside):
            yield bar.step


class _Bar:
    """What a progress bar shows, and what is said where there is none, from `spoken` on."""

    def __init__(self, progress: Progress, total: int, alike: bool, spoken: float) -> None:
        self.progress, self.alike, self.spoken = progress, alike, spoken
        self.task, self.done, self.total, self.names = progress.add_task("", total=total), -1, total, [""]
        self.shown, self.share, self.began, self.motion = time.monotonic(), 1.0, 0.0, 0

    def step(self, name: str) -> None:
        """Begin a step."""
        if not self.alike and name in self.names:  # what is tried again is one step more
            self.total += 1
        self.done, self.share, self.motion = self.done + 1, 1.0, 0
        self.names.append(name)
        self.progress.update(self.task, description=name, completed=self.done, total=self.total)
        left = self.progress.tasks[0].time_remaining if self.alike else None
        self._say(name if left is None else f"{name}, about {left:.0f} s left")

    def inside(self, share: float) -> None:
        """Show that a share of a motion is computed; a step may compute several, and their number is not known."""
        now = time.monotonic()
        if share < self.share:
            self.motion, self.began = self.motion + 1, now
        self.share = share
        if now - self.shown < OFTEN and share < 1:
            return
        self.shown, name, left = now, self.names[-1], (now - self.began) * (1 - share) / max(share, LEAST_SHARE)
        if not self.alike and share < 1:
            name += f", motion {self.motion}: {100 * share:.0f} %" if self.motion > 1 else f" {100 * share:.0f} %"
            name += f", about {left:.0f} s left" if left >= 1 and self.motion == 1 else ""
        self.progress.update(self.task, description=name, completed=max(self.done, 0) + share)
        self._say(name)

    def _say(self, line: str) -> None:
        if time.monotonic() - self.spoken >= PAUSE:
            self.spoken = time.monotonic()
            err.print(line, highlight=False, markup=False, soft_wrap=True)


def tell(line: str) -> None:
    """Print a line as it is: no colours, no markup in names, cut by nothing but the terminal."""
    out.print(line, highlight=False, markup=False, soft_wrap=True)


def print_json(data: object) -> None:
    """Print plain data as JSON, without colours."""
    tell(json.dumps(data, indent=2, allow_nan=False))


def tell_written(paths: Iterable[Path], folder: Path) -> None:
    """Tell which files are in the folder now."""
    tell(f"Wrote {', '.join(path.name for path in paths)} to {folder}")


def make_folder(folder: Path) -> None:
    """Make the folder, or say why it cannot be made; see `drop_empty_folders`."""
    missing = [path for path in (*reversed(folder.absolute().parents), folder.absolute()) if not path.exists()]
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise MechanismError(f"cannot make the folder {folder}: {error.strerror}") from error
    finally:
        _made.extend(path for path in missing if path.is_dir())


def drop_empty_folders() -> None:
    """Remove the folders that this command has made and then written nothing to, as it failed or was interrupted."""
    while _made:
        with suppress(OSError):  # it holds files
            _made.pop().rmdir()


def warn(warnings: Sequence[str], strict: bool) -> None:
    """Print warnings, or with `strict` raise a `MechanismError` for them."""
    for text in warnings:
        err.print(f"[bold yellow]warning:[/] {escape(text)}", soft_wrap=True, highlight=False)
    if strict and warnings:
        raise MechanismError("warnings are errors with --strict: change what they tell of, or leave --strict out")
