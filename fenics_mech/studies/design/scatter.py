"""The numbers of a scene that scatter: their distributions, and points that are drawn from them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError, shortened
from fenics_mech.scene import Scene
from fenics_mech.scene.study import Scatter, Value
from fenics_mech.scene.units import EXAMPLES, in_unit
from fenics_mech.studies.design.design_variables import Design, DesignVariable, named_at, refuse_twice, tied_numbers
from fenics_mech.studies.design.fit import Truths
from fenics_mech.studies.sweep_axes import range_in_si, unit_of, value_in_si

CUT = 4.0  # deviations, at which a normal distribution ends
TABLE = "study.scatter"
SAMPLINGS = ("sobol", "latin-hypercube")


@dataclass(frozen=True)
class Scattered:
    """The numbers of a scene that scatter."""

    design: Design  # the scene, with each of them as a variable from its least to its largest value
    # which have a normal distribution, cut at `CUT` deviations, ``(variables,)``. Others are as likely everywhere.
    normal: Truths

    @classmethod
    def of(cls, scene: Scene) -> Scattered:
        """Read what scatters in the study of a scene."""
        study = scene.study
        if study is None or not study.scatter:
            hint = "Add a [study.scatter] with numbers and a tolerance or deviation of each"
            raise SceneError("nothing scatters in this scene", place=TABLE, hint=hint)
        bare = scene.model_copy(update={"study": None, "measurements": ()})
        found = tuple(_read(bare, f"{TABLE}.{name}", scatter) for name, scatter in study.scatter.items())
        refuse_twice(found, TABLE)
        normal = np.array([scatter.deviation is not None for scatter in study.scatter.values()])
        return cls(Design(bare, study, found), normal)

    @property
    def deviations(self) -> Array:
        """Standard deviations in SI, ``(variables,)``."""
        from scipy.stats import truncnorm  # noqa: PLC0415  (slow to import)

        lower, upper = np.array(self.design.bounds).T
        uniform = 1 / np.sqrt(12)
        return (upper - lower) * np.where(self.normal, truncnorm.std(-CUT, CUT) / (2 * CUT), uniform)

    def values(self, chance: Array) -> Array:
        """Give the values in SI below which the numbers are with a chance, of the shape of `chance`."""
        from scipy.stats import truncnorm  # noqa: PLC0415

        lower, upper = np.array(self.design.bounds).T
        share = np.where(self.normal, 0.5 + truncnorm.ppf(chance, -CUT, CUT) / (2 * CUT), chance)
        return lower + (upper - lower) * share


def drawn(sampling: str, count: int, variables: int, seed: int) -> Array:
    """Draw points of the unit cube, ``(count, variables)``."""
    from scipy.stats import qmc  # noqa: PLC0415

    if sampling not in SAMPLINGS:
        raise SceneError(f"there is no sampling {sampling!r}", place="spread", hint=f"Known: {', '.join(SAMPLINGS)}")
    if sampling == "latin-hypercube":
        return np.asarray(qmc.LatinHypercube(variables, seed=seed).random(count))
    power = int(np.ceil(np.log2(count)))  # of fewer points the first ones are as good
    return np.asarray(qmc.Sobol(variables, seed=seed).random_base2(power))[:count]


def _read(scene: Scene, place: str, scatter: Scatter) -> DesignVariable:
    """Read one number that scatters as a variable from its least to its largest value; it starts at its mean."""
    with named_at(place):
        numbers = tied_numbers(scene, scatter.numbers)
        first = numbers[0]
        if (first.factor, first.power) != (1.0, 1.0):
            raise SceneError(
                "the first number follows with a factor or a power", hint="Begin with the number that scatters itself"
            )
        unit = unit_of(scene, first.number)
        if scatter.between is not None:
            lower, upper = range_in_si(scene, first.number, scatter.between)
            middle = (lower + upper) / 2
        else:
            middle = value_in_si(scene, first.number)
            to_side = scatter.tolerance if scatter.deviation is None else scatter.deviation
            assert to_side is not None
            half = _departure(to_side, middle, unit) * (1.0 if scatter.deviation is None else CUT)
            lower, upper = range_in_si(scene, first.number, (middle - half, middle + half))
        if not lower < upper:
            raise SceneError("the lower bound is not below the upper bound", hint="Write [smallest, largest]")
        return DesignVariable(place.rsplit(".", maxsplit=1)[-1], numbers, lower, upper, middle, unit)


def _departure(value: Value, middle: float, unit: str) -> float:
    """Read a departure from a number: in SI, with a unit, or as a share of the number."""
    try:
        if isinstance(value, str) and value.strip().endswith("%"):
            found = float(value.strip()[:-1]) / 100 * abs(middle)
        else:
            name = unit.replace(" ", "*").replace("^", "**")
            found = float(in_unit(name)(value) if name in EXAMPLES else value)
    except ValueError as error:
        raise SceneError(f"cannot read the departure {shortened(value)}: {error}") from error
    if not 0 < found < np.inf:
        raise SceneError(f"the departure {shortened(value)} is not above 0")
    return found
