"""The `fenics-mech` command."""

from __future__ import annotations

import json
import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.markup import escape

from fenics_mech._console import err, make_folder, one_voice, out, progress_bar, tell, tell_written, warn
from fenics_mech._version import __version__
from fenics_mech.errors import MechanismError

if TYPE_CHECKING:
    from fenics_mech.scene import Scene

app = typer.Typer(
    help="Dynamics of planar linkages whose links bend.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
SceneFile = Annotated[Path, typer.Argument(help="Scene file (TOML).", show_default=False)]
Refine = Annotated[int, typer.Option(min=0, max=20, help="Cut every element in two, so many times.")]
Strict = Annotated[
    bool, typer.Option("--strict", help="Stop with an error where numbers of the scene are implausible.")
]
Tolerance = typer.Option("--tol", help="Largest error, as 1e-3 (strains) or deflection=1%: it chooses mesh and steps.")
OutFolder = Annotated[Path, typer.Option("-o", "--out", help="Folder for the files; it is made when missing.")]


def main() -> None:
    """Run the command; every error of ours is one message on stderr and exit code 1."""
    try:
        app()
    except MechanismError as error:
        _fail(str(error))
    except MemoryError as error:
        _fail(f"not enough memory: take fewer sub_intervals, stations or elements, or a reduction. {error}".rstrip())
    except OSError as error:
        _fail(f"{error.filename or 'the output'}: {error.strerror or error}")


def _fail(message: str) -> None:
    err.print(f"[bold red]error:[/] {escape(message)}", soft_wrap=True, highlight=False)
    sys.exit(1)


def _loaded(path: Path, strict: bool) -> Scene:
    """Load a scene, and warn of numbers in it that are hardly meant."""
    from fenics_mech.scene import load  # noqa: PLC0415
    from fenics_mech.scene.plausibility import implausible  # noqa: PLC0415

    scene = load(path)
    warn(implausible(scene), strict)
    return scene


def _analysed(path: Path, refine: int, strict: bool, tolerance: list[str] | None = None) -> Scene:
    """Load a scene that is to be analysed; a tolerance in it, or one given here, chooses the mesh itself."""
    from fenics_mech.scene import refined, stated_tolerance  # noqa: PLC0415

    scene = _loaded(path, strict)
    scene = scene.changed(tolerance=stated_tolerance(tolerance)) if tolerance else scene
    if refine and scene.tolerance is not None:
        told = " and ".join(f"{share:g}" for share in scene.tolerances.values())
        what = f"--refine asks for a mesh, and the tolerance of {told} chooses it"
        raise MechanismError(f"{what}: give one of them")
    return refined(scene, refine)


@app.command()
def run(
    scene: SceneFile,
    folder: OutFolder = Path("out"),
    plots: Annotated[bool, typer.Option(help="Write plots.")] = True,
    csv: Annotated[bool, typer.Option(help="Write every variable as a CSV table too.")] = False,
    refine: Refine = 0,
    tolerance: Annotated[list[str] | None, Tolerance] = None,
    strict: Strict = False,
) -> None:
    """Analyse a scene: writes result.nc and plots, prints a summary. Under mpirun the processes share the positions."""
    from fenics_mech import studies, views  # noqa: PLC0415  (dolfinx and matplotlib take a second: not for --help)
    from fenics_mech._ranks import shared  # noqa: PLC0415
    from fenics_mech.analysis import STEPS, analyse  # noqa: PLC0415

    def prepared() -> Scene:
        loaded = _analysed(scene, refine, strict, tolerance)
        make_folder(folder)
        return loaded

    first = one_voice()
    loaded = shared(prepared)
    with progress_bar(len(STEPS) + 1 + plots + csv) as step:
        result = shared(lambda: analyse(loaded, step))
        if not first:
            return
        step("writing result.nc")
        written = [result.save(folder / "result.nc")]
        if csv:
            step("writing tables")
            written += result.to_csv(folder)
        if plots:
            step("plots")
            rigid = studies.rigid_body_strains(loaded) if loaded.analysis.method == "periodic" else {}
            written += views.plot_all(result, folder, rigid=rigid)
    out.print(views.summary(result))
    tell_written(written, folder)
    if strict and result.warnings:
        raise MechanismError("--strict makes the warnings above errors")


@app.command()
def modes(scene: SceneFile, folder: OutFolder = Path("out"), refine: Refine = 0, strict: Strict = False) -> None:
    """Solve for natural frequencies over the cycle: writes frequencies.csv and a plot, prints a table."""
    from fenics_mech import views  # noqa: PLC0415
    from fenics_mech.accuracy.frequency_errors import frequency_error  # noqa: PLC0415
    from fenics_mech.mechanism import RigidModes  # noqa: PLC0415
    from fenics_mech.modes import simply_supported_frequencies  # noqa: PLC0415
    from fenics_mech.planning.effect_choice import choose  # noqa: PLC0415
    from fenics_mech.response.setup import mechanism, names_of, scene_modes  # noqa: PLC0415
    from fenics_mech.scene import refined  # noqa: PLC0415

    loaded, _ = choose(refined(_loaded(scene, strict), refine))
    make_folder(folder)
    with progress_bar(4) as step:
        system = mechanism(loaded, step)
        step("modes")
        found = scene_modes(loaded, system)
        step("plot")
        supported = {label: float(f[0]) for label, f in simply_supported_frequencies(loaded).items()}
        table = views.write_frequencies(found.theta, found.frequency, folder / "frequencies.csv")
        plot = views.plot_frequencies(found.frequency, found.theta, folder / "frequencies.png", supported)
    out.print(views.frequency_table(found.frequency, found.assurance, frequency_error(system, found), supported))
    for freedom in names_of(loaded, system, RigidModes.of(system)):
        tell(f"Rigid body: {freedom}")
    tell_written((table, plot), folder)


@app.command()
def check(
    scene: Annotated[Path | None, typer.Argument(help="Scene file to check.", show_default=False)] = None,
    strict: Strict = False,
) -> None:
    """Check a scene file without analysing it; without a file, check the program against the dissertation."""
    from fenics_mech import studies, views  # noqa: PLC0415
    from fenics_mech.effects import active  # noqa: PLC0415
    from fenics_mech.kinematics import reachable_range  # noqa: PLC0415

    if scene is not None:
        loaded = _loaded(scene, strict)
        active(loaded)
        out.print(views.scene_overview(loaded, reachable_range(loaded)), highlight=False)
        return
    findings = []
    with progress_bar(len(studies.CHECKS)) as step:
        for name, examine in studies.CHECKS.items():
            step(name)
            findings += examine()
    out.print(views.check_table(findings))
    if not all(finding.holds for finding in findings):
        raise MechanismError("some checks failed: this installation does not give right numbers")


@app.command()
def effects(
    scene: SceneFile,
    compare: Annotated[bool, typer.Option("--compare", help="Run the scene with effects added one at a time.")] = False,
    folder: OutFolder = Path("out"),
    tolerance: Annotated[
        list[str] | None,
        typer.Option("--tol", help="Largest error, as 1e-3 or deflection=1%: effects above half of it act."),
    ] = None,
    strict: Strict = False,
) -> None:
    """Estimate how large each effect is in a scene, and tell which ones it calls for, without running it."""
    from fenics_mech import views  # noqa: PLC0415
    from fenics_mech.planning.effect_choice import choose  # noqa: PLC0415
    from fenics_mech.studies.effect_costs import added_one_by_one  # noqa: PLC0415

    loaded = _analysed(scene, 0, strict, tolerance).changed(effects="auto")
    with progress_bar(1) as step:
        step("effects")
        chosen, choices = choose(loaded)
    out.print(views.effects_table(choices, loaded.neglected))
    names = ", ".join(f'"{choice.effect.name}"' for choice in choices if choice.effect.name in chosen.effects)
    enough = "" if chosen.analysis.method == loaded.analysis.method else ", and method = 'quasi-static' is enough"
    tell(f"effects = 'auto' means effects = [{names}]{enough}")
    if compare:
        make_folder(folder)
        runs = added_one_by_one(loaded)
        out.print(views.runs_table(runs))
        tell_written([views.plot_effects(runs, folder / "effects.png")], folder)


@app.command()
def sweep(
    scene: SceneFile,
    over: Annotated[
        list[str],
        typer.Option(
            help="Field and its values, PATH=START:STOP:COUNT, such as drive.speed=10:60:200 or "
            "drive.speed='100 rpm:600 rpm:51'. Several make a grid.",
            show_default=False,
        ),
    ],
    folder: OutFolder = Path("out"),
    refine_peaks: Annotated[
        int, typer.Option(min=0, max=100_000, help="Most points to add where the curve of strain is not resolved.")
    ] = 0,
    member: Annotated[
        str | None, typer.Option(help="Member of the waterfall and of maps.", show_default="that of the largest strain")
    ] = None,
    s: Annotated[float, typer.Option(min=0, max=1, help="Place of the strain whose harmonics are kept.")] = 0.5,
    fibre: Annotated[str, typer.Option(help="Its fibre, + or -.")] = "+",
    harmonics: Annotated[int, typer.Option(min=1, max=10_000, help="Number of harmonics kept.")] = 20,
    refine: Refine = 0,
    strict: Strict = False,
) -> None:
    """Analyse a scene over speed, damping or any number in it: writes sweep.nc and plots.

    Ended before its time, it goes on where it was when it is started again with the same folder. Under mpirun the
    processes share the points.
    """
    from fenics_mech.studies.sweep import run_sweep  # noqa: PLC0415
    from fenics_mech.studies.sweep_axes import parse_axes  # noqa: PLC0415
    from fenics_mech.studies.sweep_points import Gauge  # noqa: PLC0415
    from fenics_mech.views.sweep_plots import check_member, plot_sweep  # noqa: PLC0415
    from fenics_mech.views.sweep_summary import sweep_summary  # noqa: PLC0415

    first = one_voice()
    loaded = _analysed(scene, refine, strict)
    axes, gauge = parse_axes(loaded, over), Gauge(s, fibre, harmonics)
    check_member(list(loaded.members()), member)
    with progress_bar(math.prod(len(axis.values) for axis in axes) + refine_peaks) as step:
        found = run_sweep(
            loaded,
            axes,
            folder,
            gauge=gauge,
            refine_peaks=refine_peaks,
            progress=lambda done, points: step(f"point {done + 1} of {points}"),
        )
    if first:
        plots = plot_sweep(found, folder, member)
        out.print(sweep_summary(found))
        tell_written([Path("sweep.nc"), Path("timings.csv"), *plots], folder)
        if (found.data["error"] != "").all():
            raise MechanismError("no point of the sweep has an answer; sweep.nc and the lines above tell why")


@app.command()
def follow(
    scene: SceneFile,
    over: Annotated[
        str,
        typer.Option(
            help="Field and its range, PATH=START:STOP, such as drive.speed=20:60 or drive.speed='200 rpm:600 rpm'.",
            show_default=False,
        ),
    ],
    folder: OutFolder = Path("out"),
    points: Annotated[int, typer.Option(min=1, max=100_000, help="Smallest number of points over the range.")] = 40,
    most_points: Annotated[int, typer.Option(min=2, max=1_000_000, help="Points after which it is given up.")] = 2000,
    refine: Refine = 0,
    strict: Strict = False,
) -> None:
    """Follow the steady state over speed, damping or any number through folds: writes branch.nc and plots.

    Stable and unstable motions are found, several at one value where there are several.
    """
    from fenics_mech.scene import refined  # noqa: PLC0415
    from fenics_mech.studies.follow import follow as follow_branch  # noqa: PLC0415
    from fenics_mech.studies.sweep_axes import parse_range  # noqa: PLC0415
    from fenics_mech.views.branch_plots import branch_summary, plot_branch  # noqa: PLC0415

    loaded = refined(_loaded(scene, strict), refine)
    path, ends = parse_range(loaded, over)
    make_folder(folder)
    with progress_bar(points) as step:
        found = follow_branch(
            loaded,
            path,
            ends,
            points=points,
            most_points=most_points,
            progress=lambda value: step(f"{path} = {value:.6g}"),
            keep=lambda branch: branch.save(folder / "branch.nc"),
        )
    written = [found.save(folder / "branch.nc"), *plot_branch(found, folder)]
    out.print(branch_summary(found))
    tell_written(written, folder)


@app.command()
def cost(
    scene: SceneFile,
    folder: OutFolder = Path("out"),
    peers: Annotated[bool, typer.Option("--peers", help="Run other programs too (the seed four-bar only).")] = False,
    quick: Annotated[bool, typer.Option("--quick", help="Few and coarse runs, to try it out.")] = False,
) -> None:
    """Measure what accuracy costs: error against time of many settings. Writes cost.csv, cost.nc and a figure."""
    from fenics_mech.studies.timing import one_thread  # noqa: PLC0415

    one_thread()  # before the numerical libraries are loaded
    from fenics_mech.scene import load  # noqa: PLC0415
    from fenics_mech.studies.cost import measure_costs, steps_of  # noqa: PLC0415
    from fenics_mech.views.cost_plots import cost_summary, write_cost  # noqa: PLC0415

    loaded = load(scene)
    if peers:
        from fenics_mech.studies.peers import compared  # noqa: PLC0415

        compared.require_ready(loaded, quick)
    make_folder(folder)
    with progress_bar(steps_of(loaded, quick)) as step:
        found = {"cost": measure_costs(loaded, quick=quick, progress=step)}
    if peers:
        with progress_bar(compared.steps_of(quick)) as step:
            found["cost_peers"] = compared.compare_peers(loaded, quick=quick, progress=step)
    for name, each in found.items():
        written = write_cost(each, folder, name)
        out.print(cost_summary(each))
        tell_written(written, folder)


@app.command()
def scaling(
    folder: OutFolder = Path("out"),
    quick: Annotated[bool, typer.Option("--quick", help="Few and small runs, to try it out.")] = False,
) -> None:
    """Measure how time and memory grow with elements, links and positions. Writes scaling.csv, scaling.nc, a figure."""
    from fenics_mech.studies.timing import one_thread  # noqa: PLC0415

    one_thread()  # before the numerical libraries are loaded
    from fenics_mech.studies.scaling import measure_scaling, sizes  # noqa: PLC0415
    from fenics_mech.views.scaling_plots import scaling_summary, write_scaling  # noqa: PLC0415

    make_folder(folder)
    asked = sizes(quick)
    with progress_bar(len(asked)) as step:
        found = measure_scaling(asked, step)
    written = write_scaling(found, folder)
    out.print(scaling_summary(found))
    tell_written(written, folder)


@app.command()
def animate(
    scene: SceneFile,
    file: Annotated[Path, typer.Option("-o", "--out", help="File to write: .gif, .mp4 or .png.")] = Path("motion.mp4"),
    magnify: Annotated[float | None, typer.Option(help="Factor on the deflection.", show_default="chosen")] = None,
    frames: Annotated[int, typer.Option(min=2, max=10_000, help="Frames in one cycle.")] = 120,
    refine: Refine = 0,
) -> None:
    """Draw the moving mechanism, deflection magnified and coloured by strain. SCENE may also be a result.nc."""
    from fenics_mech import views  # noqa: PLC0415
    from fenics_mech.analysis import STEPS, analyse  # noqa: PLC0415
    from fenics_mech.recovery import Result  # noqa: PLC0415

    views.check_ending(file)
    make_folder(file.parent)
    if scene.suffix == ".nc":
        if refine:
            raise MechanismError("a result cannot be refined: give --refine with the scene file")
        result = Result.load(scene)
    else:
        loaded = _analysed(scene, refine, strict=False)
        with progress_bar(len(STEPS)) as step:
            result = analyse(loaded, step)
    with progress_bar(frames) as step:
        views.animate(result, file, magnify=magnify, frames=frames, progress=lambda i, n: step(f"frame {i + 1} of {n}"))
    tell(f"Wrote {file}")


@app.command()
def mesh(scene: SceneFile, folder: OutFolder = Path("out"), refine: Refine = 0) -> None:
    """Mesh a scene: writes mesh.msh, mesh.vtu and mesh.xdmf at drive angle 0."""
    import numpy as np  # noqa: PLC0415

    from fenics_mech.beams import mesh_scene  # noqa: PLC0415
    from fenics_mech.beams.export import FORMATS, plane_mesh, write_mesh  # noqa: PLC0415
    from fenics_mech.kinematics import solve_motion  # noqa: PLC0415
    from fenics_mech.recovery.result import write_whole  # noqa: PLC0415
    from fenics_mech.scene import load, refined  # noqa: PLC0415

    loaded = refined(load(scene), refine)
    make_folder(folder)
    beams = mesh_scene(loaded)
    plane = plane_mesh(loaded, beams, solve_motion(loaded, np.zeros(1)))
    for ending in FORMATS:
        write_whole(folder / f"mesh{ending}", lambda temporary: write_mesh(plane, temporary))
    tell(f"{len(beams.cell)} elements, {len(beams.node_name)} nodes, {len(beams.members)} members")
    tell_written((Path(f"mesh{ending}") for ending in FORMATS), folder)


@app.command()
def schema() -> None:
    """Print the JSON Schema of scene files."""
    from fenics_mech.scene import schema as scene_schema  # noqa: PLC0415

    print(json.dumps(scene_schema(), indent=2))


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
    """Dynamics of planar linkages whose links bend."""
