"""The verdict on a machine: the least factor of safety of every member over the wanted one, its mode, and the cure."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fenics_mech.recovery.result import Result, kept
from fenics_mech.safety.buckling import across, in_plane, lateral_torsion
from fenics_mech.safety.check import KEYS, Check
from fenics_mech.safety.endurance import fatiguing, fatiguing_together
from fenics_mech.safety.loaded import Loaded
from fenics_mech.safety.pins import ASSUMED as PIN
from fenics_mech.safety.pins import DIMENSIONS, joints_of, pinned, pins
from fenics_mech.safety.resonance import resonating
from fenics_mech.safety.shapes import dimension
from fenics_mech.safety.stiffness_and_strength import ASSUMED as DEFLECTION
from fenics_mech.safety.stiffness_and_strength import deflecting, yielding
from fenics_mech.scene.sections import CustomSection

BY_SECTION: dict[str, Callable[[Loaded], Check]] = {  # modes that depend on the section
    "yield": yielding,
    "buckling in plane": in_plane,
    "buckling across": across,
    "lateral torsion": lateral_torsion,
    "fatigue": fatiguing,
    "deflection": deflecting,
}
GUESSED = frozenset({PIN, DEFLECTION})  # assumptions by which nothing is said to fail, as no grade is so low
SIDEWAYS = "buckling across", "lateral torsion"
LARGEST, HALVINGS = 64.0, 40  # times the present dimension, up to which one is looked for; halvings of the interval
DIGITS = 3  # of a dimension, rounded up


@dataclass(frozen=True)
class Cure:
    """A dimension that would do, under the same loads.

    Parameters
    ----------
    place
        Its place in the scene; the section alone where all of its dimensions grow, by `needed` over `now`.
    key
        What is changed; "" where all of them are.
    now, needed
        The dimension (m), or 1 and how many times as large the section is to be.
    """

    place: str
    key: str
    now: float
    needed: float


@dataclass(frozen=True)
class Verdict:
    """What is found of all members.

    Parameters
    ----------
    checks
        The modes of each member, by its label, the least safe member first.
    cure
        What would make the least safe one safe, if a dimension does.

    Examples
    --------
    >>> verdict = fm.judge(fm.analyse(fm.load("demos/slider_crank.toml").changed({"effects": ["coupling"]})))
    >>> sorted(verdict.checks)
    ['crank', 'rod']
    """

    checks: dict[str, tuple[Check, ...]]
    cure: Cure | None

    def least(self, member: str, decides: bool = True) -> Check | None:
        """Give the mode of a member with the least factor over the wanted one; None where there is none.

        Parameters
        ----------
        member
            Its label.
        decides
            Whether modes that rest on an assumed grade or pin are left out.
        """
        known = [check for check in self.checks[member] if (check.decides if decides else check.known)]
        return min(known, key=lambda check: check.share, default=None)

    @property
    def governing(self) -> tuple[str, Check] | None:
        """The member and the mode that decide; None where no mode does."""
        found = [(member, check) for member in self.checks if (check := self.least(member)) is not None]
        return min(found, key=lambda one: one[1].share, default=None)

    @property
    def doubtful(self) -> tuple[str, Check] | None:
        """The member and the mode that fail by an assumed grade alone; None where none does."""
        found = [
            (member, check)
            for member, checks in self.checks.items()
            for check in checks
            if check.known and check.rests_on and not GUESSED & set(check.rests_on) and check.share < 1
        ]
        return min(found, key=lambda one: one[1].share, default=None)

    @property
    def safe(self) -> bool | None:
        """Whether every mode that decides reaches its wanted factor; None where none decides."""
        return None if self.governing is None else self.governing[1].share >= 1

    @property
    def assumed(self) -> tuple[str, ...]:
        """What is assumed, each once: first what keeps modes from deciding."""
        all_checks = [check for checks in self.checks.values() for check in checks if check.known]
        first = [text for check in all_checks for text in check.rests_on]
        return tuple(dict.fromkeys([*first, *(text for check in all_checks for text in check.assumed)]))

    @property
    def missing(self) -> tuple[str, ...]:
        """Modes that are not judged and why, each reason once."""
        missing = [check for checks in self.checks.values() for check in checks if check.missing]
        return tuple(dict.fromkeys(f"{check.mode}: {check.missing}" for check in missing))


def without_cure(result: Result) -> Verdict:
    """Judge every member of a result by all modes, and look for no cure."""
    found = _of_cases(result) if result.cases else _of_one(result)
    verdict = Verdict(found, None)
    shares = {label: least.share if (least := verdict.least(label)) else math.inf for label in found}
    return Verdict({label: found[label] for label in sorted(found, key=shares.__getitem__)}, None)


@kept
def judge(result: Result) -> Verdict:
    """Judge every member of a result by all modes.

    Parameters
    ----------
    result
        The result, of links that bend.

    Returns
    -------
    Verdict
        Factors of safety, and the cure of the least safe member.

    Examples
    --------
    >>> verdict = fm.judge(fm.Result.load("out/result.nc"))
    >>> sorted(verdict.checks)
    ['coupler', 'crank', 'follower']
    """
    verdict = without_cure(result)
    governing = verdict.governing
    if governing is None or governing[1].share >= 1:
        return verdict
    label, check = governing
    return replace(verdict, cure=cure_of(_loads(label, result), check))


def _of_one(result: Result) -> dict[str, tuple[Check, ...]]:
    """Judge every member of a result of one load case by all modes."""
    found: dict[str, tuple[Check, ...]] = {}
    for label, (link, member) in result.scene.members().items():
        of = Loaded(label, member, result)
        checks = {mode: judged(of) for mode, judged in BY_SECTION.items()}
        checks |= {"pin and eye": pins(of), "resonance": resonating(result, link)}
        found[label] = tuple(replace(checks[mode], case=result.case) for mode in KEYS)
    return found


def _of_cases(every: Result) -> dict[str, tuple[Check, ...]]:
    """Give the least of all load cases for every member and mode; fatigue counts all of them where they tell cycles."""
    # Of a mode that rests on an assumption in one case alone both are kept: what decides, and before it what does
    # not.
    each = [without_cure(result) for result in every.cases.values()]
    found: dict[str, tuple[Check, ...]] = {}
    for label in each[0].checks:
        found[label] = ()
        for mode in KEYS:
            checks = [check for one in each for check in one.checks[label] if check.mode == mode]
            if mode == "fatigue" and (together := fatiguing_together(_loads(label, every))) is not None:
                checks = [together]
            known, decide = ([one for one in checks if one.known], [one for one in checks if one.decides])
            least = [min(some, key=lambda check: check.share) for some in (known, decide) if some]
            found[label] += tuple(dict.fromkeys(least)) or tuple(checks[:1])
    return found


def _loads(label: str, result: Result) -> list[Loaded]:
    """Give a member under its loads in every load case."""
    member = result.scene.members()[label][1]
    cases = result.cases or {result.case: result}
    return [Loaded(label, member, one, cycles=result.cycles.get(case)) for case, one in cases.items()]


def cure_of(loads: Sequence[Loaded], check: Check) -> Cure | None:
    """Find the dimension with which a member reaches the wanted factor of a mode, under the same loads."""
    # The mode itself is judged with changed dimensions, so that its own law of scaling is followed.
    of = next(one for one in loads if one.result.case == check.case)
    if check.mode == "pin and eye":
        return _of_pin(loads, check)
    if check.mode not in BY_SECTION:
        return None
    section, key = of.section, dimension(of.section, check.mode in SIDEWAYS)
    factor = _least(lambda x: _worst([one.resized(key, x) for one in loads], check.mode) if x != 1 else check)
    if check.mode == "deflection":
        factor = _stiffer(of, key, check)
    if factor is None:
        return None
    place = f"sections.{of.member.section}"
    if not key:
        return Cure(place, "", 1.0, _rounded_up(factor))
    now = float(getattr(section, key))
    stated = not isinstance(of.scene.sections[of.member.section], CustomSection)
    return Cure(f"{place}.{key}" if stated else place, key, now, _rounded_up(now * factor))


def _stiffer(of: Loaded, key: str, check: Check) -> float | None:
    """Find the factor on a dimension at which a member's own bending, which goes with 1/I, leaves the limit."""
    own = check.acting  # all of it where an end is free
    if not of.between_joints[1]:
        own = float(np.abs(of.result.derived("deflection_from_chord").sel(member=of.label)).max())
    rest = check.acting - own
    if rest >= check.borne:  # its ends move by more, by what carries them
        return None
    needed = own / (check.borne - rest)
    low, high = 1.0, LARGEST
    for _ in range(HALVINGS):
        middle = math.sqrt(low * high)
        low, high = (low, middle) if of.resized(key, middle).enlarged.inertia >= needed else (middle, high)
    return high


def _worst(loads: Sequence[Loaded], mode: str) -> Check:
    """Judge a member by a mode in all load cases."""
    together = fatiguing_together(loads) if mode == "fatigue" else None
    return together or min((BY_SECTION[mode](one) for one in loads), key=lambda check: check.share)


def _of_pin(loads: Sequence[Loaded], check: Check) -> Cure | None:
    """Find the dimension of a stated pin that would do."""
    weakest, _, name = check.detail.partition(", ")
    pin, key = dict(joints_of(loads[0]))[name].pin, DIMENSIONS[weakest]
    if pin is None:
        return None
    now = float(getattr(pin, key))

    def judged(x: float) -> Check:
        changed = pin.model_copy(update={key: now * x})
        return min((pinned(one, name, changed) for one in loads), key=lambda check: check.share)

    factor = _least(judged)
    return None if factor is None else Cure(f"joints.{name}.pin.{key}", key, now, _rounded_up(now * factor))


def _least(judged: Callable[[float], Check]) -> float | None:
    """Find the least factor on a dimension at which a mode reaches the wanted factor; None where none does."""
    low = high = 1.0
    while judged(high).share < 1:
        low, high = high, high * 1.25
        if high > LARGEST:
            return None
    for _ in range(HALVINGS):
        middle = math.sqrt(low * high)
        low, high = (low, middle) if judged(middle).share >= 1 else (middle, high)
        if high / low < 1 + 1e-4:
            break
    return high


def _rounded_up(value: float) -> float:
    """Round up to `DIGITS` significant digits."""
    step = 10.0 ** (math.floor(math.log10(value)) - DIGITS + 1)
    return math.ceil(value / step - 1e-9) * step
