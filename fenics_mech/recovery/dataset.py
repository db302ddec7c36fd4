"""Putting everything that was computed into one labelled dataset."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from fenics_mech.effects import EFFECTS
from fenics_mech.effects.effect import Choice
from fenics_mech.estimate.error_sources import Errors
from fenics_mech.estimate.quantities import ERROR_VARIABLES


def joined(*parts: xr.Dataset) -> xr.Dataset:
    """Put datasets with the same labels together, without a look at whether these are the same."""
    return xr.merge(parts, combine_attrs="no_conflicts", compat="override", join="override")


def of_errors(errors: Errors) -> xr.Dataset:
    """Give errors by source of every quantity that the scene has, and the largest relative ones by all of them."""
    variables: dict[str, Any] = {}
    attributes: dict[str, float | str] = {}
    for what, (name, prefix, places) in ERROR_VARIABLES.items():
        if what not in errors.errors or (what == "torque" and not errors.measure[what].size):  # nothing is driven
            continue
        variables[f"{name}_error"] = (("source", places), np.stack(list(errors.errors[what].values())))
        variables[f"{prefix}relative_error"] = (("source",), list(errors.relative(what).values()))
        attributes[f"{prefix}error_estimate"] = errors.total(what)
    sources = list(errors.order)
    variables["error_order"] = (("source",), [float(errors.order[source]) for source in sources])
    labels: dict[str, Any] = {"source": sources}
    if errors.missed is not None:
        variables |= errors.missed.of_points(sources)
        labels["point"] = list(errors.missed.points)
    attributes["too_coarse"] = int(errors.too_large)
    if errors.remarks:
        attributes["not_estimated"] = "; ".join(errors.remarks)
    return xr.Dataset(variables, labels, attributes)


def decisions(dofs: int, elements: int, choices: Sequence[Choice]) -> dict[str, object]:
    """Attributes that say what was decided; the effects as JSON: name, size if it was estimated, whether it acts."""
    effects = [{"name": c.effect.name, "size": c.size, "acts": c.acts, "lacking": c.missing} for c in choices]
    return {"dofs": dofs, "elements": elements, "effects": json.dumps(effects)}


def choices_in(data: xr.Dataset) -> list[Choice]:
    """Give what was decided about effects of this program, as `decisions` put it into a result."""
    told = (one for one in json.loads(data.attrs.get("effects", "[]")) if one["name"] in EFFECTS)
    return [Choice(EFFECTS[one["name"]], one["size"], one["acts"], one["lacking"]) for one in told]
