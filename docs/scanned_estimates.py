"""How true estimated errors of chapter 5 are: `python docs/scanned_estimates.py` prints its row of `theory/errors.md`.

Four machines by sub-intervals with few or more elements, steps and modes, against one motion by collocation of the same
equation. It takes some minutes.
"""

import itertools

import numpy as np
from hard_estimates import DEMOS, FINER, LENIENT, NOT_COMPARED, error_of

import fenics_mech as fm

ELEMENTS, STEPS, MODES = (1, 2, 4), (60, 120, 240), (2, 5)
FINEST, SHORTEST = 8, 720  # elements a member and sub-intervals of the reference
TAPER = {"shape": "variable", "area": "4e-5*(1 - 0.5*s)", "inertia": "8e-12*(1 - 0.5*s)**3", "fibre": 8e-4}


def main() -> None:
    """Run the scan, and print smallest and median ratio of all runs and of those that are not refused."""
    ratios, accepted = [], []
    for name, scene in machines().items():
        finer = {f"analysis.{option}": value for option, value in FINER.items()}
        reference = fm.analyse(meshed(scene, FINEST, SHORTEST).changed(finer))
        for elements, steps, modes in itertools.product(ELEMENTS, STEPS, MODES):
            given = {"analysis.solver": "sub-intervals", "analysis.modes": modes}
            try:
                found = fm.analyse(meshed(scene, elements, steps).changed(given))
            except fm.MechanismError as error:
                print(name, elements, steps, modes, f"refused: {type(error).__name__}", sep="; ", flush=True)
                continue
            told = float(found.data["relative_error"].drop_sel(source=NOT_COMPARED, errors="ignore").sum())
            true = error_of(found, reference)
            refused = bool(found.data.attrs["too_coarse"])
            print(
                name,
                elements,
                steps,
                modes,
                f"{told:.1e}; {true:.1e}; {told / true:.2f}",
                refused,
                sep="; ",
                flush=True,
            )
            ratios.append(told / true)
            accepted += [] if refused else [told / true]
    for words, some in (("all", ratios), ("not refused", accepted)):
        print(f"{words}: {len(some)} runs, {min(some):.2g}, {np.median(some):.2g}")


def machines() -> dict[str, fm.Scene]:
    """Give the machines, with the equation (5.1), a damping ratio of 2 % and what else they state."""
    seed, *others = (fm.load(DEMOS / f"{name}.toml") for name in ("four_bar", "slider_crank", "quick_return"))
    every = {"seed": seed, "tapered seed": seed.changed({"sections.strip": TAPER})}
    every |= dict(zip(("slider-crank", "quick return"), others))
    return {name: scene.changed(effects=(), damping={"ratio": 0.02}) for name, scene in every.items()}


def meshed(scene: fm.Scene, elements: int, steps: int) -> fm.Scene:
    """Give a scene with so many elements on each member, and so many sub-intervals."""
    own = [(link, name) for link, body in scene.links.items() for name, one in body.members.items() if one.mesh]
    given = {f"links.{link}.members.{name}.mesh": None for link, name in own} | {"mesh.elements": elements}
    options = LENIENT | {"allow_ringing": True, "sub_intervals": steps, "stability": False}
    return scene.changed(given | {f"analysis.{option}": value for option, value in options.items()})


if __name__ == "__main__":
    main()
