"""What a scene states about how it is to be analysed."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import Field, field_validator, model_validator

from fenics_mech.errors import SceneError
from fenics_mech.scene.base import SCENE, Part
from fenics_mech.scene.poincare import PoincareSection
from fenics_mech.scene.units import Angle, Share, Time
from fenics_mech.scene.updating import without_neutral

STATED_STARTS = "rigid", "static", "smooth", "periodic"  # any other `start` names the file of a result
MOST_POSITIONS = 100_000  # of a motion in time at which a result is held
LARGEST_TOLERANCE = 0.02  # of steps in time: beyond it they are as long as they may be


class Analysis(Part):
    """What to compute and with which numerical options.

    Parameters
    ----------
    method
        "periodic" (chapter 5); "transient" (in time, from a start); "quasi-static" (loads and inertia of the rigid
        motion); "static" (loads only, held at one position, appendix C; with freedoms, the equilibrium near the rough
        angles).
    solver
        "auto" takes "sub-intervals" for a periodic motion without the effect "coupling" where that method knows all
        that the scene states, and the equation of poses for all others. "sub-intervals" is the dissertation's method
        (chapter 5): equation (5.1) and modal damping; of "transient" the superposition of `modes` in time (E.13).
        "collocation" and "poses" solve the equation of poses by steps of high order, and "harmonic-balance" by a
        Fourier series. Linear theories are its first step from the rigid motion.
    stages
        Radau points in a sub-interval; in a time step of "transient" at least 5.
    harmonics
        Harmonics of the Fourier series. They need more than four times as many sub-intervals.
    stability
        Find the Floquet multipliers of a periodic response by collocation or harmonic balance.
    error_estimates
        Estimate the errors of the answer, which takes about half of the time. Without it nothing tells whether mesh,
        steps and theory suffice, and none are made finer because they do not: for sweeps whose worst points are known.
        "contacts" also estimates the error of time steps where contacts open, from a motion with half their tolerance.
    critical_speeds
        Find the critical speeds of a machine that its drives lead: which harmonic of the drive meets which mode.
    out_of_plane
        Let the links also bend across the plane and twist: the result has frequencies and multipliers of these motions,
        and a machine that buckles across its plane is refused. Sections are stated by their shapes then.
    allow_unstable
        Accept a periodic motion or an equilibrium of freedoms that is unstable: small disturbances grow.
    start
        Of "transient": "rigid" (links straight and without elastic velocity) or "static" (bent by loads and rigid
        motion). With freedoms also "smooth" (on the slow motion, without vibration), and "periodic" (on the motion
        that repeats). The file of a result of "transient" of the same scene goes on from its end.
    start_time
        Of a file: the time from which the motion goes on (s), one of those at which its result is given. Without it,
        the end. Where links bend, a result holds the state of its end only.
    duration
        Of "transient" where nothing is driven: how long the motion goes on (s). It is given at `sub_intervals` equal
        parts of it. With start = "periodic" it is the period of the forces; where they have none, about that of the
        motion.
    repeats
        With start = "periodic": after how many cycles of the drives, or periods of the forces, the motion repeats. It
        is looked for after `cycles` of them, or earlier where `settled` says so.
    lyapunov
        Find the Lyapunov exponents of a motion with freedoms: the rates at which motions beside it part.
    poincare
        Keep the state of the freedoms once in a period, or as often as one passes a place.
    cycles, settled
        "transient" ends after that many cycles of the drive at full speed, which follow the run-up. It ends earlier
        when two cycles differ by less than `settled` of the largest displacement; 0 never ends it. Two cycles always
        differ by the errors of their time steps.
    time_tolerance
        Relative error of a time step of "transient", 1e-12 or more.
    position
        Drive coordinate (rad) at which "static" holds the linkage.
    sub_intervals
        Number of sub-intervals of the cycle; results are given at their middles, the first at drive angle 0. More
        are taken where the answer needs them, unless the scene states how many.
    modes
        Number of modes kept, or "all".
    static_correction
        Let the modes that are left out answer statically.
    join
        How sub-intervals are joined. "physical": displacement and momentum of the mechanism go on. "projected": its
        displacement and velocity go on as far as the modes kept can follow; the same with all modes. "modal": each
        modal coordinate goes on by itself, as (5.14) prints it, which does not converge to the solution of (5.1).
    load
        The modal load in a sub-interval is "constant", that of its middle, or "linear" in time through it.
    allow_ringing
        Accept free vibration of modes faster than half the rate of the sub-intervals, which the joins excite.
    allow_coarse
        Take mesh and steps as they are. Without it those that the scene does not state are made finer where the strain
        error is more than 2 % by the steps, or 5 % by steps, mesh and modes. So they are at a joint force error of half
        of the largest. With it, positions may also miss a corner of the rigid motion.
    allow_large
        Accept deflections far beyond small ones. Axes turn by more than 1 rad against the rigid motion, or points move
        by more than the member's length.
    stations
        Number of equally spaced points along each member at which results are given.

    Examples
    --------
    >>> fm.Analysis(method="transient", cycles=3).cycles
    3
    """

    method: Literal["periodic", "transient", "quasi-static", "static"] = "periodic"
    solver: Literal["auto", "sub-intervals", "collocation", "harmonic-balance", "poses"] = "auto"
    stages: Annotated[int, Field(ge=1, le=9)] = 3
    harmonics: Annotated[int, Field(ge=1, le=10_000)] = 60
    stability: bool = True
    error_estimates: bool | Literal["contacts"] = True
    critical_speeds: bool = True
    out_of_plane: bool = False
    allow_unstable: bool = False
    start: str = "rigid"
    start_time: Annotated[Time, Field(ge=0)] | None = None
    duration: Annotated[Time, Field(gt=0)] | None = None
    repeats: Annotated[int, Field(ge=1, le=64)] = 1
    lyapunov: bool = False
    poincare: PoincareSection | None = None
    cycles: Annotated[int, Field(ge=1)] = 20
    settled: Annotated[Share, Field(ge=0)] = 1e-3
    time_tolerance: Annotated[Share, Field(gt=0, lt=1)] = 1e-5
    position: Angle = 0.0
    sub_intervals: Annotated[int, Field(ge=4, le=SCENE.most_sub_intervals)] = 360
    modes: Annotated[int, Field(ge=1)] | Literal["all"] = 5
    static_correction: bool = True
    join: Literal["physical", "projected", "modal"] = "physical"
    load: Literal["constant", "linear"] = "linear"
    allow_ringing: bool = False
    allow_coarse: bool = False
    allow_large: bool = False
    stations: Annotated[int, Field(ge=2, le=SCENE.most_stations)] = 21

    @model_validator(mode="before")
    @classmethod
    def _of_earlier_versions(cls, data: Any) -> Any:
        return without_neutral(data) if isinstance(data, dict) else data

    @field_validator("time_tolerance")
    @classmethod
    def _is_above_rounding(cls, value: float) -> float:
        if value < SCENE.finest_steps:
            raise ValueError(
                f"must be at least {SCENE.finest_steps:g}, to which the equation of motion is computed, found {value:g}"
                ": smaller ones make steps shorter without a smaller error"
            )
        return value


def refuse_rough(analysis: Analysis) -> None:
    """Raise `SceneError` where a tolerance does not govern the steps in time.

    Parameters
    ----------
    analysis
        What the scene asks for.
    """
    if analysis.time_tolerance > LARGEST_TOLERANCE:
        raise SceneError(
            f"{analysis.time_tolerance:g} is more than {LARGEST_TOLERANCE:g}, up to which it governs the steps in time",
            place="analysis.time_tolerance",
            hint="Take a smaller one: the error of the steps is not known with this one",
        )
