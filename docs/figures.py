"""Make the pictures of the tutorial anew: `python docs/figures.py FOLDER`.

It takes about five minutes. The folder keeps the sweeps.
"""

import subprocess
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import xarray as xr

import fenics_mech as fm

DOCS = Path(__file__).parent
RPM = 30 / np.pi  # of 1 rad/s
ALLOWED = 90.0  # MPa, the strength in press.toml
MODULUS = 207e9 / 1e6  # MPa


def main(folder: Path) -> None:
    """Sweep the speed of both designs and draw what the tutorial shows."""
    scene = (DOCS / "tutorial" / "press.toml").read_text()
    designs = {"4 mm": scene, "5 mm": scene.replace('height = "4 mm"', 'height = "5 mm"')}
    sweeps = {height: swept(text, folder / height.replace(" ", "_")) for height, text in designs.items()}
    plt.rcParams.update({"font.size": 10, "axes.spines.top": False, "axes.spines.right": False, "savefig.dpi": 110})
    over_speed({"rocker of 4 mm": sweeps["4 mm"]}, DOCS / "images" / "press_speeds.png", crossings=True)
    over_speed({f"rocker of {h}": data for h, data in sweeps.items()}, DOCS / "images" / "press_decision.png")
    command("run", folder / "4_mm" / "scene.toml", "-o", folder / "run")
    result = fm.Result.load(folder / "run" / "result.nc")
    fm.plot_strain(result, "rocker.CB").figure.savefig(DOCS / "images" / "press_rocker.png")
    picture = DOCS / "images" / "press_motion.png"
    command("animate", folder / "4_mm" / "scene.toml", "-o", picture, "--frames", "12")


def swept(text: str, folder: Path) -> xr.Dataset:
    """Sweep a scene over the speed; what the folder has already is not computed again."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "scene.toml").write_text(text)
    command("sweep", folder / "scene.toml", "--over", "drive.speed=250 rpm:650 rpm:41", "-o", folder)
    with xr.open_dataset(folder / "sweep.nc") as data:
        return data.load()


def command(*words: object) -> None:
    """Run the program's command."""
    subprocess.run([sys.executable, "-m", "fenics_mech", *map(str, words)], check=True)


def over_speed(designs: dict[str, xr.Dataset], file: Path, crossings: bool = False) -> None:
    """Draw the largest stress over the speed of the crank."""
    figure, axes = plt.subplots(figsize=(7.2, 3.6), layout="constrained")
    for (label, data), colour in zip(designs.items(), ("tab:blue", "tab:orange")):
        speed = data["drive.speed"].to_numpy() * RPM
        stress = data["peak_strain"].max("member", skipna=False).to_numpy() * MODULUS
        axes.plot(speed, stress, "o-", color=colour, markersize=3.5, label=label)
        failed = np.isnan(stress)
        axes.plot(speed[failed], np.full(failed.sum(), 20), "x", color=colour, label=f"{label}: refused")
    if crossings:
        mode = float(fm.modes(fm.load(DOCS / "tutorial" / "press.toml")).data["frequency"].mean("theta")[1])
        for multiple in range(10, 21):
            axes.axvline(60 * mode / multiple, color="0.75", linewidth=0.8, zorder=0)
            axes.text(60 * mode / multiple, 212, f"{multiple}x", ha="center", fontsize=8, color="0.4")
    axes.axhline(ALLOWED, color="tab:red", linestyle="--", linewidth=1, label="allowed")
    axes.set(xlabel="speed of the crank (rpm)", ylabel="largest stress (MPa)", xlim=(245, 655), ylim=(0, 210))
    axes.legend(frameon=False, loc="upper left")
    figure.savefig(file)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
