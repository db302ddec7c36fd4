"""Natural frequencies of a linkage over its cycle, without a response."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import xarray as xr

from fenics_mech._arrays import Array, Index
from fenics_mech._guard import guarded
from fenics_mech.answers.modes_by_poses import LARGEST_KNOWN, HeldMachine, at_rest
from fenics_mech.answers.solved_by_poses import FREE, with_effects
from fenics_mech.beams.simply_supported import simply_supported_frequencies
from fenics_mech.effects import EFFECTS
from fenics_mech.effects.known import SHEAR
from fenics_mech.effects.shear import assumed
from fenics_mech.errors import SceneError
from fenics_mech.estimate.beam_theory import frequency_shares
from fenics_mech.planning.sampling_checks import require_positions
from fenics_mech.recovery.of_scene import OfScene
from fenics_mech.recovery.result import stamp
from fenics_mech.scene import Scene
from fenics_mech.scene.drives import Harmonics
from fenics_mech.scene.meshing import with_halves

PLACES = np.linspace(0, 1, 21)  # along every member, at which mode shapes are given
LOOKED_AT = 8  # positions, of which errors are estimated
LACK = 4.0  # by which halved elements lessen errors of stretching and shear; those of bending fall by 16


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
        - frequency_error, the relative error of each frequency by the mesh: what halved elements change, and what they
          lack themselves,
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


@guarded()
def modes(scene: Scene, progress: Callable[[str], None] = lambda step: None) -> NaturalFrequencies:
    """Solve for the natural frequencies of a linkage at equal steps over its cycle.

    Joints that are free to move by their own equation are held where they start.

    Parameters
    ----------
    scene
        The scene: ``analysis.modes`` states how many modes, ``analysis.sub_intervals`` at how many positions. With
        ``effects = "auto"`` shear and rotary inertia act where the scene states what they need.
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
    SceneError
        When no link bends, or the scene has what the equation of poses does not have.
    SolverError
        When the stiffness is not positive at a position, or the eigenvalue solver does not converge.

    Examples
    --------
    >>> found = fm.modes(fm.load("demos/four_bar.toml").changed({"analysis.sub_intervals": 12}))
    >>> dict(found.data["frequency"].sizes)
    {'theta': 12, 'mode': 5}
    >>> found.free
    ()
    """
    if not scene.members():
        raise SceneError("no link has a member: there is nothing that bends", place="links")
    progress("kinematics")
    chosen = at_rest(with_effects(scene))
    require_positions(chosen, chosen.analysis.sub_intervals if chosen.drives else 1)
    held = HeldMachine.of(chosen)
    progress("modes")
    found, frequency, supported = held.modes, held.frequency, simply_supported_frequencies(chosen)
    running, shapes = held.running(), held.along(found.shapes, PLACES)
    largest = np.linalg.norm(shapes, axis=-1).max(axis=(2, 3))
    shapes = shapes / np.where(largest == 0, 1.0, largest)[..., None, None, None]
    theory, said = _by_theory(scene, held)
    free = [
        f"the freedom at joint {drive.joint} is held where it starts, at {_told(scene, drive.joint, drive.law.mean)}"
        for drive in chosen.drives
        if drive.joint in scene.freedoms and isinstance(drive.law, Harmonics)
    ]
    data = xr.Dataset(
        {
            "frequency": (("theta", "mode"), frequency, {"units": "Hz"}),
            "running_frequency": (
                ("theta", "mode"),
                np.full_like(frequency, np.nan) if running is None else running,
                {"units": "Hz"},
            ),
            "assurance": (("theta", "mode"), found.assurance, {"units": "1"}),
            "frequency_error": ("mode", _by_mesh(held), {"units": "1"}),
            "theory_error": ("mode", theory, {"units": "1"}),
            "shape": (("theta", "mode", "member", "s", "component"), shapes, {"units": "1"}),
            "supported": ("member", [float(lowest[0]) for lowest in supported.values()], {"units": "Hz"}),
        },
        {
            "theta": ("theta", chosen.cycle_rate * held.t if chosen.drives else 0 * held.t, {"units": "rad"}),
            "mode": range(1, frequency.shape[1] + 1),
            "member": list(supported),
            "s": PLACES,
            "component": ["x", "y"],
        },
        stamp(scene) | {"decisions": "\n".join(said)} | {"free": "\n".join([*held.free, *free])},
    )
    return NaturalFrequencies(data)


def _by_mesh(held: HeldMachine) -> Array:
    """Give errors of the frequencies by the mesh ``(modes,)``: by their ranks they are those by halved elements."""
    scene, at = held.made.scene, _looked_at(held)
    ranks = np.argsort(np.argsort(held.every.omega[at], axis=1), axis=1)[:, : held.count]
    finer = replace(HeldMachine.of(with_halves(scene), held), t=held.t[at])
    found, exact = held.modes.omega[at], np.take_along_axis(np.sort(finer.every.omega, axis=1), ranks, axis=1)
    off = np.abs(np.divide(found, exact, out=np.ones_like(exact), where=exact > 0) - 1)
    return np.minimum(LACK / (LACK - 1) * off.mean(axis=0), LARGEST_KNOWN)


def _looked_at(held: HeldMachine) -> Index:
    """Give the numbers of a few positions."""
    return np.unique(np.linspace(0, len(held.t), LOOKED_AT, endpoint=False).astype(int))


def _by_theory(scene: Scene, held: HeldMachine) -> tuple[Array, list[str]]:
    """Give the share of each frequency that shear and rotary inertia would take off where they do not act."""
    # Where the program chooses them, it says by how much they change frequencies, or what is missing.
    chosen, at = held.made.scene, _looked_at(held)
    assert held.made.links is not None
    few = replace(held, t=held.t[at])
    shapes = few.of_nodes(held.modes.shapes[at])
    shares = frequency_shares(chosen, held.made.links, held.modes.omega[at], shapes)
    acting = [name for name in FREE if name in chosen.named_effects]
    error = sum((share for name, share in shares.items() if name not in acting), np.zeros(held.count))
    said = []
    if scene.effects == "auto":
        large = [name for name, share in shares.items() if share.max(initial=0.0) > scene.neglected / 2]
        missing = {name: EFFECTS[name].missing_data(chosen) for name in large if name not in acting}
        said = [f"{name} is left out: {what}" for name, what in missing.items()]
        if added := [name for name in large if name in acting]:
            kept = tuple(name for name in chosen.named_effects if name not in added)
            thin = replace(HeldMachine.of(chosen.model_copy(update={"effects": kept}), held), t=held.t[at])
            both = (np.sort(omega, axis=1)[:, : held.count] for omega in (thin.every.omega, held.every.omega[at]))
            before, after = (omega.mean(axis=0) for omega in both)
            most = np.divide(before - after, before, out=np.zeros_like(before), where=before > 0).max()
            said.append(f"{' and '.join(added)} act here: they change these frequencies by up to {100 * most:.2g} %")
    if SHEAR in acting:
        said += assumed(chosen)
    return error, said


def _told(scene: Scene, joint: str, place: float) -> str:
    """Say an angle or a stroke of a joint."""
    return f"{place:.6g} m" if hasattr(scene.joints[joint], "angle") else f"{np.degrees(place):.6g} deg"
