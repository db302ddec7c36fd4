"""Measures of the elements of a term, and the stresses that answer them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from fenics_mech._arrays import Array, Index
from fenics_mech.terms import Response


@cache
def _in_triangle(n: int) -> Index:
    """Give where the entries of a symmetric matrix lie in its lower triangle ``(n, n)``."""
    at = np.zeros((n, n), dtype=int)
    i, j = np.tril_indices(n)
    at[i, j] = at[j, i] = np.arange(len(i))
    return at


@dataclass(frozen=True)
class Measured:
    """Measures of the elements of a term."""

    x: Array  # measures and their rates (instants, elements, measures)
    rate: Array
    gradient: Array  # by the way between both poses and both chart vectors: (..., variables), and the lower triangle
    hessian: Array
    ways: Array  # rates of these variables, (instants, elements, variables)
    response: Response  # the stresses
    modes: Array | None = None  # patterns of stress of the term, as of `Term.patterns`

    @property
    def power(self) -> Array:
        """Power that the elements take ``(instants, elements)`` (W)."""
        return np.sum(self.response.stress * self.rate, axis=-1)

    @property
    def rate_by_variables(self) -> Array:
        """Derivatives of the rates by the variables ``(instants, elements, measures, variables)``."""
        whole = np.take(self.hessian, _in_triangle(self.gradient.shape[-1]), axis=-1)
        return np.einsum("temab,teb->tema", whole, self.ways)

    def predicted(self, change: Array, change_of_ways: Array, change_of_modes: Array, change_of_pulls: Array) -> Array:
        """Give the stresses after a change of the variables, their rates, the modes and multipliers, to first order."""
        stress = self.response.stress.copy()
        x = np.einsum("temn,ten->tem", self.gradient, change)
        rate = np.einsum("temn,ten->tem", self.gradient, change_of_ways)
        if self.response.by_rate is not None:
            rate += np.einsum("temn,ten->tem", self.rate_by_variables, change)
        for derivative, y in ((self.response.by_measure, x), (self.response.by_rate, rate)):
            if derivative is not None:
                of_sets = y.reshape(*derivative.shape[:2], -1)
                stress += np.einsum("tsij,tsj->tsi", derivative, of_sets).reshape(stress.shape)
        if self.modes is not None:
            stress += np.einsum("temk,tk->tem", self.modes, change_of_modes)
        if self.response.by_pulls is not None:
            stress += np.einsum("temr,tr->tem", self.response.by_pulls, change_of_pulls)
        return stress
