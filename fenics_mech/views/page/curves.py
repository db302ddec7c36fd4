"""Arrays that the page draws, packed: 16-bit differences from position to position, deflated, in letters."""

from __future__ import annotations

import base64
import zlib
from typing import Any

import numpy as np

from fenics_mech._arrays import Array, Index
from fenics_mech._constants import MEGA, MICRO, MILLI, TINY, TURN
from fenics_mech.recovery.peaks import smoothed
from fenics_mech.recovery.signal import PEAK as AT_PEAK
from fenics_mech.views.frames import default_magnification
from fenics_mech.views.geometry import ends_of, motion_of
from fenics_mech.views.joint_drawings import ground_points, guides_of, pin_places, rigid_bars, slider_angles
from fenics_mech.views.reading import Reading

STEPS = 32767  # of a 16-bit number
DRAWN = 2047  # of deflections, which are drawn and not told: a tenth of a pixel
MOST = 1200  # positions of a motion in time; more do not show on a screen
MOST_HARMONICS = 60


def payload(reading: Reading) -> dict[str, Any]:
    """Give what the script of the page draws.

    Parameters
    ----------
    reading
        The result.
    """
    shown = _shown(reading)
    arrays = {**_strains(reading), **_places(reading)}
    names = {"members": reading.members, "joints": reading.joints, "fibres": reading.fibres}
    return {
        "title": reading.scene.name,
        **_axis(reading, shown),
        **names,
        "ends": [list(ends) for ends in reading.ends],
        "s": reading.s.tolist(),
        "lengths": (MILLI * reading.lengths).tolist(),
        "peaks": [[int(np.flatnonzero(shown == peak.k)[0]), peak.j, peak.f] for peak in reading.peaks],
        "magnify": default_magnification(reading.result),
        "effort": list(reading.effort_name) if reading.effort is not None else None,
        **_spectrum(reading),
        "arrays": {name: packed(values[shown], DRAWN if name == "bent" else STEPS) for name, values in arrays.items()},
    }


def packed(values: Array, steps: int = STEPS) -> dict[str, Any]:
    """Round to a share of the largest value, take differences from position to position, and deflate.

    Parameters
    ----------
    values
        Numbers, ``(positions, ...)``.
    steps
        Whole number that stands for the largest value, at most 32767.

    Returns
    -------
    dict
        Numbers at each position, "row"; "scale", by which the whole numbers are multiplied; "data" in base64, first the
        low bytes of all differences and then the high ones.
    """
    values = np.nan_to_num(np.asarray(values, dtype=float).reshape(len(values), -1))
    scale = max(float(np.abs(values).max(initial=0.0)), TINY * steps) / steps
    differences = np.diff(np.rint(values / scale).astype(np.int64), axis=0, prepend=0).astype("<i2")  # modulo 2^16
    planes = differences.reshape(-1).view(np.uint8).reshape(-1, 2).T.tobytes()
    text = base64.b64encode(zlib.compress(planes, 9)).decode()
    return {"row": values.shape[1], "scale": scale, "data": text}


def _shown(reading: Reading) -> Index:
    """Numbers of the positions that are shown: of a turn all by their angle, of a long motion some and all peaks."""
    if not reading.in_time:
        angle = np.mod(np.round(reading.theta, 12), TURN)
        return np.argsort(angle, kind="stable")
    count = len(reading.theta)
    some = np.unique(np.linspace(0, count - 1, min(count, MOST)).round().astype(int))
    peaks = [peak.k for peak in reading.peaks] + [int(k) for k in reading.force.argmax(axis=0)]
    peaks += [int(np.abs(reading.effort).argmax())] if reading.effort is not None else []
    return np.union1d(some, peaks)


def _axis(reading: Reading, shown: Index) -> dict[str, Any]:
    """What the positions are along: the drive angle (degrees), or time (s)."""
    if reading.in_time:
        time = reading.data["time"].to_numpy()[shown]
        return {"kind": "time", "axis": time.round(9).tolist(), "seconds": float(np.ptp(time)), "direction": 1}
    angle = np.degrees(np.mod(np.round(reading.theta, 12), TURN))[shown]
    turns = len(angle) > 1
    back = turns and reading.theta[1] < reading.theta[0]
    kind = "turn" if turns else "still"
    seconds = float(reading.scene.period) if reading.scene.drives else 1.0
    return {"kind": kind, "axis": angle.round(4).tolist(), "seconds": seconds, "direction": -1 if back else 1}


def _strains(reading: Reading) -> dict[str, Array]:
    """Stresses (MPa), strains (micrometres per metre), forces (N) and what else is drawn as curves."""
    data = reading.result.data
    found = {
        "stress": reading.stress,
        "strain": reading.strain,
        "force": reading.of("joint_force", "joint", "component"),
    }
    if reading.effort is not None:
        found["effort"] = reading.effort
    if "frequency" in data:
        found["frequency"] = smoothed(reading.result, data["frequency"].transpose("theta", "mode").to_numpy())[1]
    for name, unit in (("strain", MICRO), ("stress", MEGA)):
        if (still := f"{name}_quasi_static") in data:
            curves = unit * data[still].transpose("theta", "member", "s", "fibre").to_numpy()
            at_peaks = np.stack([curves[:, peak.i, peak.j, peak.f] for peak in reading.peaks], axis=1)
            found[f"{name}_still"] = smoothed(reading.result, at_peaks)[1]
    return found


def _places(reading: Reading) -> dict[str, Array]:
    """Where members, pins and guides are in the rigid linkage, and how far they move by deflection (m)."""
    result, scene = reading.result, reading.scene
    data, motion = result.data, motion_of(result)
    ends = ends_of(result)
    bent, s = data["deflection"].transpose("theta", "member", "s", "component").to_numpy(), reading.s[:, None]
    straight = (1 - s) * ends[:, :, None, 0] + s * ends[:, :, None, 1]
    pins = pin_places(scene, motion, straight)
    moved = pin_places(scene, motion, straight + bent)
    bars, moved_bars = (rigid_bars(scene, motion, at) for at in (pins, moved))
    _, angles = slider_angles(scene, motion)
    found = {"ends": ends, "bent": bent, "pins": pins, "pins_bent": moved - pins}
    found |= {
        "bars": bars,
        "bars_bent": moved_bars - bars,
        "guides": np.stack([np.cos(angles), np.sin(angles)], axis=-1),
    }
    return {name: smoothed(result, values)[1] for name, values in found.items()}


def _spectrum(reading: Reading) -> dict[str, Any]:
    """What does not depend on the position: ground, guides, harmonics of the strain, multipliers."""
    result, scene = reading.result, reading.scene
    data, motion = result.data, motion_of(result)
    found: dict[str, Any] = {
        "ground": ground_points(scene).tolist(),
        "tracks": guides_of(scene, motion).tolist(),
        "sliders": slider_angles(scene, motion)[0],
    }
    if "strain_amplitude" in data:
        amplitude = data["strain_amplitude"].sel(gauge=AT_PEAK).transpose("member", "harmonic").to_numpy()
        found["harmonics"] = _rounded(MICRO * amplitude[:, : MOST_HARMONICS + 1])
    if "multiplier" in data:
        found["multipliers"] = _rounded(data["multiplier"].transpose("disturbance", "part").to_numpy())
    return found


def _rounded(values: Array) -> list[list[float]]:
    return [[float(f"{value:.4g}") for value in line] for line in np.nan_to_num(values)]
