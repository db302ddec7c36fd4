"""Natural frequencies of a linkage over its cycle, without a response."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array
from fenics_mech.accuracy.beam_theory import frequency_shares
from fenics_mech.accuracy.frequency_errors import frequency_error
from fenics_mech.accuracy.joint_map_errors import JOINTS, in_frequencies, left_out_of_frequencies
from fenics_mech.effects import EFFECTS
from fenics_mech.effects.shear import EFFECT as SHEAR
from fenics_mech.effects.shear import assumed
from fenics_mech.eigenmodes import simply_supported_frequencies, solve_modes
from fenics_mech.eigenmodes.tracking import Modes
from fenics_mech.forces.section_forces import deflection_of_nodes
from fenics_mech.mechanism import RigidModes, System
from fenics_mech.planning.effect_choice import choose
from fenics_mech.recovery.of_scene import OfScene
from fenics_mech.recovery.result import stamp
from fenics_mech.response.running_frequencies import running_frequencies
from fenics_mech.response.setup import CommonParts, freedoms_in_words, mechanism
from fenics_mech.scene import Scene

PLACES = np.linspace(0, 1, 21)  # along every member, at which mode shapes are given


@dataclass(frozen=True)
class NaturalFrequencies(OfScene):
    """What `modes` found.

    Parameters
    ----------
    data
        Coordinates theta (rad), mode (from 1), member, s (places 0 to 1 along it), component. Variables are

        - frequency (Hz), by theta and mode, of the mechanism held at each position,
        - running_frequency (Hz), by theta and mode, about the motion: with spin, and with axial forces of loads and
          rigid motion. NaN where nothing runs or loads, and 0 where a disturbance diverges,
        - assurance, the modal assurance criterion of each mode with itself at the next position, by theta and mode,
        - frequency_error, the estimated relative error of each frequency by the mesh,
        - theory_error, the share by which shear flexibility and rotary inertia of the beams would lower it, where they
          do not act,
        - shape, the displacement of the members' axes in the fixed frame over its largest, by theta, mode, member, s
          and component,
        - supported (Hz), the lowest frequency of each member as a simply supported beam, (7.6).

    Examples
    --------
    >>> found = fm.modes(fm.load("demos/four_bar.toml").changed({"analysis.sub_intervals": 12}))
    >>> found.data["frequency"].sel(mode=1).min().item() < found.data["supported"].sel(member="coupler").item()
    True
    """

    KIND: ClassVar[str] = "set of natural frequencies"
    NEEDED: ClassVar[tuple[str, ...]] = ("fenics_mech", "free")

    @property
    def decisions(self) -> tuple[str, ...]:
        """What was decided about shear flexibility and rotary inertia by their shares of the frequencies, in words."""
        return tuple(str(self.data.attrs.get("decisions", "")).splitlines())

    @property
    def free(self) -> tuple[str, ...]:
        """Motions of the rigid links that no joint, drive or spring prevents, in words."""
        return tuple(str(self.data.attrs["free"]).splitlines())

    @property
    def warnings(self) -> tuple[str, ...]:
        """What is wrong with the frequencies, in sentences."""
        return tuple(str(self.data.attrs.get("warnings", "")).splitlines())


def modes(scene: Scene, progress: Callable[[str], None] = lambda step: None) -> NaturalFrequencies:
    """Solve for the natural frequencies of a linkage at equal steps over its cycle.

    Parameters
    ----------
    scene
        The scene: ``analysis.modes`` states how many modes, ``analysis.sub_intervals`` at how many positions. With
        ``effects = "auto"`` shear and rotary inertia act where they change a frequency by more than half of what may
        be neglected.
    progress
        Called with the name of each step as it begins.

    Returns
    -------
    NaturalFrequencies
        Frequencies (Hz) over the drive angle, how surely they were tracked, their error by the mesh, and the rigid-body
        freedoms in words.

    Raises
    ------
    AssemblyError
        When the links cannot be assembled at some drive angle.
    SolverError
        When the eigenvalue solver does not converge.

    Examples
    --------
    >>> found = fm.modes(fm.load("demos/four_bar.toml").changed({"analysis.sub_intervals": 12}))
    >>> dict(found.data["frequency"].sizes)
    {'theta': 12, 'mode': 5}
    >>> found.free
    ()
    """
    chosen, system, found, shares, said = _chosen(scene, progress)
    left = left_out_of_frequencies(chosen, system, lambda: found)
    running = running_frequencies(chosen, system, found)
    unknown = np.full_like(found.frequency, np.nan)
    supported = simply_supported_frequencies(chosen)
    data = xr.Dataset(
        {
            "frequency": (("theta", "mode"), found.frequency, {"units": "Hz"}),
            "running_frequency": (("theta", "mode"), unknown if running is None else running, {"units": "Hz"}),
            "assurance": (("theta", "mode"), found.assurance, {"units": "1"}),
            "frequency_error": ("mode", frequency_error(system, found), {"units": "1"}),
            "theory_error": ("mode", sum(shares.values(), np.zeros(found.omega.shape[1])), {"units": "1"}),
            "shape": (("theta", "mode", "member", "s", "component"), _shapes(system, found), {"units": "1"}),
            "supported": ("member", [float(lowest[0]) for lowest in supported.values()], {"units": "Hz"}),
        },
        {
            "theta": ("theta", found.theta, {"units": "rad"}),
            "mode": range(1, found.frequency.shape[1] + 1),
            "member": list(supported),
            "s": PLACES,
            "component": ["x", "y"],
        },
        stamp(chosen)
        | {"decisions": "\n".join(said)}
        | {"free": "\n".join(freedoms_in_words(chosen.links, chosen.joints, system, RigidModes.of(system)))},
    )
    if left is not None and left[1] >= JOINTS.warned:
        data.attrs["warnings"] = in_frequencies(*left)
    return NaturalFrequencies(data)


def _chosen(scene: Scene, progress: Callable[[str], None]) -> tuple[Scene, System, Modes, dict[str, Array], list[str]]:
    """The scene with effects that its frequencies call for, its mechanism and modes, what is left out, and words."""
    common = CommonParts()
    chosen, _ = choose(scene, common)
    system = mechanism(chosen, progress, common)
    progress("modes")
    found = solve_modes(system, chosen.analysis.modes, chosen.petsc)
    shares, said = frequency_shares(chosen, system, found), []
    if scene.effects == "auto":
        large = [name for name, share in shares.items() if share.max(initial=0.0) > scene.neglected / 2]
        missing = {name: what for name in large if (what := EFFECTS[name].missing_data(chosen))}
        said = [f"{name} is left out: {what}" for name, what in missing.items()]
        if added := tuple(name for name in large if name not in missing):
            chosen = chosen.changed(effects=(*chosen.named_effects, *added))
            system, before = mechanism(chosen, common=common), found.omega
            found = solve_modes(system, chosen.analysis.modes, chosen.petsc)
            after, before = (np.sort(omega, axis=1).mean(axis=0) for omega in (found.omega, before))
            most = np.divide(before - after, before, out=np.zeros_like(before), where=before > 0).max()
            said.append(f"{' and '.join(added)} act here: they change these frequencies by up to {100 * most:.2g} %")
            shares = frequency_shares(chosen, system, found)
    if SHEAR.name in chosen.named_effects:
        said += assumed(chosen)
    return chosen, system, found, shares, said


def _shapes(system: System, found: Modes) -> Array:
    """Displacement of the members' axes in each mode over its largest, ``(angles, modes, members, places, 2)``."""
    moved = [deflection_of_nodes(system, system.to_links(shape), PLACES) for shape in np.moveaxis(found.shapes, 1, 0)]
    shapes = np.stack(moved, axis=1)
    largest = np.linalg.norm(shapes, axis=-1).max(axis=(2, 3))
    return np.asarray(shapes / np.where(largest == 0, 1.0, largest)[..., None, None, None])
