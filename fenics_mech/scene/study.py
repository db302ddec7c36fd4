"""What a study varies, what it aims at, and within which limits."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field

from fenics_mech.errors import shortened
from fenics_mech.scene.base import Name, Part
from fenics_mech.scene.units import Angle, Length

Value = float | str  # a number in SI, or a text with a unit


class Tied(Part):
    """A number of the scene that follows a variable: ``factor * variable ** power``.

    Parameters
    ----------
    number
        Its dotted path in the scene.
    factor, power
        How it follows.

    Examples
    --------
    >>> fm.Tied(number="sections.strip.inertia", factor=1e-4, power=3).power
    3.0
    """

    number: str
    factor: float = 1.0
    power: float = 1.0


class Variable(Part):
    """What a study varies: a number of the scene, several numbers that are tied together, or a choice.

    Parameters
    ----------
    numbers
        Dotted paths of the numbers, or numbers with a factor and a power. A variable of several has one value.
    between
        Smallest and largest value: SI, or texts with a unit of the first number.
    choices
        Values of a variable that is a choice, such as the names of sections of a catalogue; they need no order.
    start
        Value from which a search begins. By default it is that of the scene.

    Examples
    --------
    >>> fm.Variable(numbers=["sections.strip.height"], between=["1 mm", "4 mm"]).between
    ('1 mm', '4 mm')
    """

    numbers: Annotated[tuple[str | Tied, ...], Field(min_length=1)]
    between: tuple[Value, Value] | None = None
    choices: tuple[Any, ...] = ()
    start: Any = None

    def _check_keys(self) -> None:
        if (self.between is None) == (not self.choices):
            raise ValueError("a variable needs either `between`, its bounds, or `choices`")


class Scatter(Part):
    """How a number of the scene scatters, or several numbers that scatter together: one of three ways.

    Parameters
    ----------
    numbers
        Dotted paths of the numbers, or numbers with a factor and a power, as of a variable.
    tolerance
        Largest departure from the number of the scene, to both sides; all values are as likely. SI, or a text with a
        unit; "2 %" is a share of the number.
    deviation
        Standard deviation of a normal distribution about the number of the scene, cut at four deviations.
    between
        Smallest and largest value; all values are as likely.

    Examples
    --------
    >>> fm.Scatter(numbers=["sections.strip.height"], tolerance="0.05 mm").deviation is None
    True
    """

    numbers: Annotated[tuple[str | Tied, ...], Field(min_length=1)]
    tolerance: Value | None = None
    deviation: Value | None = None
    between: tuple[Value, Value] | None = None

    def _check_keys(self) -> None:
        if [self.tolerance, self.deviation, self.between].count(None) != 2:
            raise ValueError("state one of `tolerance`, `deviation` and `between`")


class Limit(Part):
    """A limit on a number of the result.

    Parameters
    ----------
    of
        The number, as "strain[coupler].max".
    least, most
        The limits: SI, or texts with a unit.

    Examples
    --------
    >>> fm.Limit(of="stress.max", most="60 MPa").least is None
    True
    """

    of: str
    least: Value | None = None
    most: Value | None = None

    def _check_keys(self) -> None:
        if self.least is None and self.most is None:
            raise ValueError("a limit needs `least` or `most`")


class Target(Part):
    """The path that a point of a link is to follow.

    Parameters
    ----------
    point
        The point: "link.point", or the name of a point in `points`.
    path
        Places of the path in the fixed frame (m).
    angles
        Drive angles (rad) at which the point is to be at each place. Without them it is to pass them at any angle.

    Examples
    --------
    >>> len(fm.Target(point="coupler.P", path=[(0, 0.1), ("10 cm", 0.1)]).path)
    2
    """

    point: str
    path: Annotated[tuple[tuple[Length, Length], ...], Field(min_length=1, max_length=100_000)]
    angles: tuple[Angle, ...] = ()

    def _check_keys(self) -> None:
        if self.angles and len(self.angles) != len(self.path):
            raise ValueError(f"there are {len(self.path)} places and {len(self.angles)} angles: give as many")


class Study(Part):
    """A study of a scene: what it varies, and which numbers of the result it looks at.

    Parameters
    ----------
    variables
        What a search varies, by name.
    scatter
        What scatters, by name.
    minimise, maximise
        Numbers of the result that are to be small, or large, such as "mass", "strain.max" or "shaking_force.rms".
    limits
        Limits on numbers of the result.
    results
        Other numbers of the result that are kept of every trial.
    curves
        Curves over the drive angle whose scatter is told, such as "strain[coupler][@0.5][+]" or "torque".
    targets
        Paths that points are to follow, by name: "tracer_error[NAME].rms".

    Examples
    --------
    >>> height = fm.Variable(numbers=["sections.strip.height"], between=["1 mm", "4 mm"])
    >>> study = fm.Study(variables={"height": height}, minimise=["mass"], limits=[{"of": "strain.max", "most": 1e-3}])
    >>> study.names
    ('mass', 'strain.max')
    """

    variables: Annotated[dict[Name, Variable], Field(max_length=1000)] = Field(default_factory=dict)
    scatter: Annotated[dict[Name, Scatter], Field(max_length=1000)] = Field(default_factory=dict)
    minimise: tuple[str, ...] = ()
    maximise: tuple[str, ...] = ()
    limits: tuple[Limit, ...] = ()
    results: tuple[str, ...] = ()
    curves: tuple[str, ...] = ()
    targets: dict[Name, Target] = Field(default_factory=dict)

    def _check_keys(self) -> None:
        aims = [*self.minimise, *self.maximise]
        if twice := next((name for name in aims if aims.count(name) > 1), ""):
            raise ValueError(f"{shortened(twice)} is named as an aim twice: name it once")

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all numbers of the result that the study looks at, each once."""
        limited = (limit.of for limit in self.limits)
        return tuple(dict.fromkeys((*self.minimise, *self.maximise, *limited, *self.results)))
