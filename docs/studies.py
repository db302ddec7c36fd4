"""Run the studies of `docs/studies.md` as they stand there, and draw their pictures: `python docs/studies.py FOLDER`.

It takes about two minutes. The folder keeps what the commands write.
"""

import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np

import fenics_mech as fm
from fenics_mech.views.figures import COLOURS, angle_axis, curve, empty_figure, finish, save

DOCS = Path(__file__).parent
IMAGES = DOCS / "images"
PAGE = (DOCS / "studies.md").read_text()
DEMO = DOCS.parent / "demos" / "four_bar.toml"
LIGHTER, DAMPING = (tomllib.loads(text) for text in re.findall(r"```toml\n(.*?)```", PAGE, flags=re.DOTALL))
POSITIONS = {"analysis.sub_intervals": 180}
TRUTH, NOISE, EVERY = 0.027, 6e-6, 5  # damping ratio and noise of the record, and which positions it has


def main(folder: Path) -> None:
    """Run the three studies and draw what the page shows."""
    folder.mkdir(parents=True, exist_ok=True)
    lighter_coupler(folder)
    counterweights(folder)
    damping(folder)


def with_tables(tables: dict) -> fm.Scene:
    """The demo with the tables of the page."""
    parts = {f"{table}.{key}": value for table in ("sections", "links") for key, value in tables.get(table, {}).items()}
    return fm.load(DEMO).changed(parts | POSITIONS | {"study": tables["study"]})


def command(*words: object) -> None:
    """Run a command of the program."""
    subprocess.run([sys.executable, "-m", "fenics_mech", *map(str, words)], check=True)


def lighter_coupler(folder: Path) -> None:
    """Search for a lighter coupler, and draw its strain before and after."""
    scene = with_tables(LIGHTER)
    command("optimise", fm.write_scene(scene, folder / "lighter.toml"), "-o", folder / "lighter")
    figure, (axes,) = empty_figure()
    for name, result in (("before", fm.analyse(scene)), ("after", fm.Result.load(folder / "lighter" / "result.nc"))):
        strain = 1e6 * result.data["strain"].sel(member="coupler", fibre="-").transpose("theta", "s").to_numpy()
        worst = np.abs(strain).max(axis=0).argmax()
        mass = 1e3 * mass_of(result.scene)
        axes.plot(*curve(result.data["theta"].to_numpy(), strain[:, worst]), label=f"{name}: {mass:.1f} g")
    limit = 1e6 * LIGHTER["study"]["limits"][0]["most"]
    for sign, name in ((1, f"limit: {limit:.0f} \N{MICRO SIGN}m/m"), (-1, None)):
        axes.axhline(sign * limit, color="0.3", lw=0.9, ls="--", label=name)
    angle_axis(axes)
    finish(axes, "Strain of the coupler where it is largest", "strain (\N{MICRO SIGN}m/m)", columns=3)
    save(figure, IMAGES / "study_coupler.png")


def mass_of(scene: fm.Scene) -> float:
    """Mass of the coupler (kg)."""
    from fenics_mech.studies.design.result_numbers import total_mass  # noqa: PLC0415

    return total_mass(scene, ["coupler"])


def counterweights(folder: Path) -> None:
    """Balance the four-bar, and draw its shaking force with links that bend."""
    command("balance", DEMO, "--section", "crank", "-o", folder / "both.toml")
    command("balance", DEMO, "--on", "crank=50 mm", "-o", folder / "crank.toml")
    figure, (axes,) = empty_figure()
    files = {"no counterweight": DEMO, "crank and follower": folder / "both.toml", "crank": folder / "crank.toml"}
    for (name, file), colour in zip(files.items(), COLOURS):
        result = fm.analyse(fm.load(file))
        force = np.linalg.norm(result.data["shaking_force"].transpose("theta", "component").to_numpy(), axis=1)
        axes.plot(
            *curve(result.data["theta"].to_numpy(), force), color=colour, label=f"{name}: up to {force.max():.1f} N"
        )
    angle_axis(axes)
    finish(axes, "Shaking force of links that bend", "shaking force (N)", columns=2)
    save(figure, IMAGES / "study_counterweights.png")


def damping(folder: Path) -> None:
    """Make a record with noise, and find its damping ratio."""
    truth = fm.analyse(fm.load(DEMO).changed({"damping.ratio": TRUTH}))
    angles, strain = (values[::EVERY] for values in (truth.data["theta"].to_numpy(), truth.strain_at("coupler")))
    measured = strain + NOISE * np.random.default_rng(25).normal(size=len(strain))
    lines = [f"{np.degrees(angle):.0f},{value:.3e}" for angle, value in zip(angles, measured)]
    (folder / "record.csv").write_text("\n".join(["angle_deg,strain[coupler][@0.5][+]", *lines]) + "\n")
    scene = fm.write_scene(with_tables(DAMPING), folder / "damping.toml")
    command("identify", scene, folder / "record.csv", "-o", folder / "damping")
    shutil.copy(folder / "damping" / "prediction_1.png", IMAGES / "study_damping.png")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
