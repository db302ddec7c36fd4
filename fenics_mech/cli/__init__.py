"""The `fenics-mech` command: one module a command, and what they have in common in `common`."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import wraps
from inspect import Parameter, signature
from typing import Annotated, Any

import typer
from rich.markup import escape

from fenics_mech._console import drop_empty_folders, err, log_to_terminal, print_in_any_encoding, start_libraries
from fenics_mech._libraries import launched
from fenics_mech._version import __version__
from fenics_mech.cli.animate_command import animate
from fenics_mech.cli.balance_command import balance
from fenics_mech.cli.check_command import check
from fenics_mech.cli.compare_command import compare
from fenics_mech.cli.effects_command import effects
from fenics_mech.cli.export_command import export
from fenics_mech.cli.fatigue_command import fatigue
from fenics_mech.cli.follow_command import follow
from fenics_mech.cli.identify_command import identify
from fenics_mech.cli.import_command import import_scene
from fenics_mech.cli.mesh_command import mesh
from fenics_mech.cli.modes_command import modes
from fenics_mech.cli.optimise_command import optimise
from fenics_mech.cli.plot_command import plot
from fenics_mech.cli.refine_command import refine
from fenics_mech.cli.report_command import report
from fenics_mech.cli.run_command import run
from fenics_mech.cli.schema_command import schema
from fenics_mech.cli.sound_command import sound
from fenics_mech.cli.spread_command import spread
from fenics_mech.cli.sweep_command import sweep
from fenics_mech.cli.synthesise_command import synthesise
from fenics_mech.errors import MechanismError

app = typer.Typer(
    help="Dynamics of linkages whose links bend, in the plane and in space.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


Verbose = Annotated[bool, typer.Option("-v", "--verbose", help="Also print what the program does, step by step.")]


def _with_log(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command the option --verbose."""

    @wraps(command)
    def logging(*arguments: Any, verbose: bool = False, **options: Any) -> None:
        log_to_terminal(verbose)
        command(*arguments, **options)

    own = signature(command, eval_str=True)
    option = Parameter("verbose", Parameter.KEYWORD_ONLY, default=False, annotation=Verbose)
    logging.__signature__ = own.replace(parameters=[*own.parameters.values(), option])  # type: ignore[attr-defined]
    logging.__annotations__ = command.__annotations__ | {"verbose": Verbose}
    return logging


def _with_libraries(command: Callable[..., None]) -> Callable[..., None]:
    """Give the command that first starts the numerical libraries; the others are quick because they do without."""

    @wraps(command)
    def started(*arguments: Any, **options: Any) -> None:
        if options.get("jobs", 1) > 1 and not launched():
            from fenics_mech.studies.worker_processes import prepare  # noqa: PLC0415

            prepare(_SHARED[command])
        start_libraries(solver=command not in _OF_RESULTS)
        command(*arguments, **options)

    return started


_COMMANDS = (
    *(run, modes, check, effects, sweep, optimise, identify, spread, balance, synthesise),
    *(follow, compare, refine, fatigue, sound),
    *(animate, plot, report, export, import_scene, mesh, schema),
)
_SHARED = {  # modules of what processes do that `--jobs` starts
    run: "fenics_mech.studies.case_runs",
    sweep: "fenics_mech.studies.sweep_points",
    **dict.fromkeys((optimise, identify, spread), "fenics_mech.studies.design.trial"),
}
_QUICK = check, import_scene, schema
_OF_RESULTS = compare, fatigue, animate, plot, report, export  # which take a result without a solver too
for _command in _COMMANDS:
    _name = "import" if _command is import_scene else None  # a word that Python keeps for itself
    app.command(_name)(_with_log(_command if _command in _QUICK else _with_libraries(_command)))


def main() -> None:
    """Run the command, which leaves no empty folder where it fails."""
    print_in_any_encoding()
    try:
        _run()
    except BaseException as ended:
        if getattr(ended, "code", 1):  # of processes that share the work one alone writes, and others end before it
            drop_empty_folders()
        raise


def _run() -> None:
    """Run the command; every error of ours is one message on stderr and exit code 1."""
    try:
        app()
    except MechanismError as error:
        _fail(str(error))
    except MemoryError as error:
        _fail(f"not enough memory: take fewer sub_intervals, stations or elements, or a reduction. {error}".rstrip())
    except ImportError as error:
        _fail(f"a library is missing or cannot be loaded: {error}. Install it, or give the process more memory")
    except OSError as error:
        _fail(f"{error.filename or 'the output'}: {error.strerror or error}")


def _fail(message: str) -> None:
    err.print(f"[bold red]error:[/] {escape(message)}", soft_wrap=True, highlight=False)
    sys.exit(1)


def _version(asked: bool) -> None:
    if asked:
        print(__version__)
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Dynamics of linkages whose links bend, in the plane and in space."""
