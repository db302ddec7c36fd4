"""Fatigue of a member's body: by an endurance limit, or by the stress-life curve of its material."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech._constants import MEGA
from fenics_mech.errors import MechanismError
from fenics_mech.recovery.faces import Face
from fenics_mech.recovery.peaks import curves_over_cycle
from fenics_mech.recovery.result import at_place
from fenics_mech.recovery.stress_figures import stress_cycles
from fenics_mech.safety.check import Check, unknown, wanted
from fenics_mech.safety.grades import grade_of, ultimate_of
from fenics_mech.safety.loaded import Loaded
from fenics_mech.scene import Material, RoundSection, TubeSection
from fenics_mech.scene.bodies import StressLife
from fenics_mech.scene.load_cases import CYCLES

MODE = "fatigue"
AXIAL = 0.85  # load factor kc of axial stress (Shigley's Mechanical Engineering Design, 9th ed., eq. (6-26))
SURFACES = {  # ka = a Su^b, at most 1, with Su in MPa (the same, table 6-2; machined also stands for cold-drawn)
    "ground": (1.58, -0.085),
    "machined": (4.51, -0.265),
    "hot-rolled": (57.7, -0.718),
    "as-forged": (272.0, -0.995),
}
LARGEST = 1e6  # factor of safety that is looked for
HALVINGS = 60  # of the interval in which it lies, in its logarithm


def fatiguing(of: Loaded) -> Check:
    """Judge the stresses of a cycle at every place and material."""
    if len(of.theta) < 2:
        return unknown(MODE, "a single position has no cycle of stress")
    found = []
    for face in of.faces:
        material = of.scene.materials[face.material]
        curve, cycles = material.fatigue, of.scene.design.cycles or CYCLES
        check = _by_curve([(of, face, cycles)], curve) if curve else _by_limit(of, face, material)
        if not check.known:
            return check
        taken = curve is not None and of.scene.design.cycles is None
        found.append(check.also_assumed(f"{face.material} is to last {cycles:.3g} cycles" if taken else ""))
    return min(found, key=lambda check: check.share, default=unknown(MODE, "its section names no material"))


def fatiguing_together(loads: Sequence[Loaded]) -> Check | None:
    """Judge a member by the damage of all load cases, where these tell how many cycles each has; None where not."""
    # By an endurance limit, which knows no number of cycles, the worst case that runs at all decides.
    running = [of for of in loads if of.cycles]
    if not running or any(of.cycles is None for of in loads):
        return None
    found = []
    for number, face in enumerate(running[0].faces):
        material = running[0].scene.materials[face.material]
        if material.fatigue is not None:
            found.append(_by_curve([(of, of.faces[number], of.cycles or 0.0) for of in running], material.fatigue))
        else:
            found += [replace(_by_limit(of, of.faces[number], material), case=of.result.case) for of in running]
    unjudged = [check for check in found if not check.known]
    return unjudged[0] if unjudged else min(found, key=lambda check: check.share, default=None)


def endurance(material: Material, ultimate: float) -> float | None:
    """Give ka Se', the endurance limit in bending of a small part with the material's surface (Pa), if known."""
    # ultimate: its tensile strength (Pa)
    if (grade := grade_of(material)) is None:
        return None
    a, b = SURFACES[material.surface or "machined"]
    surface = min(a * (ultimate * MEGA) ** b, 1.0)
    return surface * min(grade.endurance * ultimate, grade.highest)


def size_factor(diameter: float) -> float:
    """Give kb in bending (Shigley's, 9th ed., eq. (6-20)), at most 1."""
    # diameter: equivalent diameter (m)
    d = min(max(diameter * 1e3, 2.79), 254.0)
    return min(1.24 * d**-0.107 if d <= 51 else 1.51 * d**-0.157, 1.0)


def _equivalent_diameter(of: Loaded) -> float:
    """Diameter of a rotating round with the same volume near its largest stress (m), of a part that does not rotate."""
    if isinstance(of.section, RoundSection | TubeSection):
        return 0.370 * of.section.diameter * of.enlarged.fibre  # eq. (6-24)
    modulus = of.scene.materials[of.faces[0].material].modulus
    return 0.808 * math.sqrt(float(of.stretching.max()) / modulus)  # eq. (6-25), of a rectangle h b


def _by_limit(of: Loaded, face: Face, material: Material) -> Check:
    """Judge by Goodman's line, ``1/n = Kf (sigma_a/Se + sigma_m/Su)`` (Shigley's, 9th ed., eq. (6-46))."""
    # Bending and axial stresses have factors of their own: ``sigma_a/Se = (sigma_b/kb + sigma_ax/kc)/(ka Se')``
    # (section 6-14). Kf raises the mean too (section 6-10). A mean compression does not help.
    # The cycle from the least to the largest stress decides: no other that rainflow counts lies outside of it, and
    # what its amplitude is less counts by 1/Se, what its mean is more by 1/Su, which is less.
    known = ultimate_of(face.material, material)
    limit = endurance(material, known[0]) if known else None
    if known is None or limit is None:
        return unknown(MODE, f"state materials.{face.material}.fatigue, a stress-life curve")
    ultimate, rests = known
    bent, drawn, notches = _at_places(of, face)
    highest, lowest = _cycle(of, bent / size_factor(_equivalent_diameter(of)) + drawn / AXIAL)
    amplitude = (highest - lowest) / 2
    highest, lowest = _cycle(of, bent + drawn)
    mean = np.clip((highest + lowest) / 2, 0, None)
    used = notches * (amplitude / limit + mean / ultimate)
    acting = float(used.max()) * limit
    check = Check(MODE, acting, limit, "stress", wanted(of.scene.design, MODE), rests_on=(rests,) if rests else ())
    surface = "" if material.surface else f"{face.material} is machined"
    notch = "" if of.member.notches else "no notches where none are stated"
    reliable = "mean endurance limits"
    return check.also_assumed(surface, notch, reliable)


def _by_curve(parts: Sequence[tuple[Loaded, Face, float]], curve: StressLife) -> Check:
    """Judge by the factor on all stresses at which Miner's sum of the wanted cycles is 1, counted by rainflow."""
    # `parts` are the member in every load case, its face and the cycles of the machine in that case.
    first, all_waves, counted = parts[0][0], [], []
    for of, face, cycles in parts:
        bent, drawn, notches = _at_places(of, face, first.stations)
        wave = (bent + drawn) * notches
        if of.part is not None:
            wave = curves_over_cycle(of.scene, wave[of.part], "stress").turning()
        try:
            rows = [stress_cycles(one, of.part is not None).T for one in wave.T]
        except MechanismError as error:
            return unknown(MODE, str(error))
        counted.append([np.array([ranges, mean, count * cycles]) for ranges, mean, count in rows])
        all_waves.append(wave)
    places = [np.concatenate(place, axis=1) for place in zip(*counted)]
    factors = [_factor(ranges, mean, count, curve) for ranges, mean, count in places]
    j = int(np.argmin(factors))
    damages = [float(place[j][2] @ curve.damage(*(factors[j] * place[j][:2]))) for place in counted]
    worst = int(np.argmax(damages))
    acting, case = float(np.ptp(all_waves[worst][:, j])), parts[worst][0].result.case
    borne, lasting = acting * factors[j], f"{sum(cycles for *_, cycles in parts):.3g} cycles"
    told = lasting + (" of all cases" if len(parts) > 1 else "")
    wanted_factor = wanted(first.scene.design, MODE)
    return Check(MODE, acting if borne else 0.0, borne or 1.0, "stress", wanted_factor, detail=told, case=case)


def _factor(ranges: Array, mean: Array, count: Array, curve: StressLife) -> float:
    """Find the factor on the stresses at which the damage is 1, between 1 over `LARGEST` and that."""
    low, high = -math.log(LARGEST), math.log(LARGEST)
    for _ in range(HALVINGS):
        middle = math.exp((low + high) / 2)
        if float(count @ curve.damage(middle * ranges, middle * mean)) < 1:
            low = math.log(middle)
        else:
            high = math.log(middle)
    return math.exp(low)


def _at_places(of: Loaded, face: Face, stations: Array | None = None) -> tuple[Array, Array, Array]:
    """Stress by bending and by the axial force, ``(angles, places)``, at stations and notches; notch factors there."""
    # The stations are its own, or those of another load case.
    axial, bending = of.axial_and_bending
    drawn, bent = (face.stress(*np.moveaxis(values, -1, 0)) for values in (axial, bending))
    stations = of.stations if stations is None else stations
    at = np.array([*stations, *(notch.at for notch in of.member.notches)])
    factors = np.array([1.0] * len(stations) + [notch.kf for notch in of.member.notches])
    if not np.array_equal(at, of.stations):
        bent, drawn = (np.stack([at_place(one, of.stations, s) for s in at], axis=1) for one in (bent, drawn))
    return bent, drawn, factors


def _cycle(of: Loaded, values: Array) -> tuple[Array, Array]:
    """Highest and lowest values of a cycle, or of all positions where there is none."""
    if of.part is None:
        return values.max(axis=0), values.min(axis=0)
    curves = curves_over_cycle(of.scene, values[of.part], "stress")
    return curves.highest()[1], curves.lowest()[1]
