"""MECQBAR against the numbers printed in Appendix G."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.validation.reference import FourBarParameters, compare_appendix_g, mecqbar


def test_every_printed_number_agrees() -> None:
    comparison = compare_appendix_g()
    assert comparison.disagreeing == ()
    assert (comparison.compared, comparison.agreeing, comparison.same_digits) == (844, 844, 844)


@pytest.mark.parametrize("wrong", [{"c": 0.2705}, {"mass_B": 0.0375}, {"rho": 2710.0}, {"omega1": 32.31}])
def test_comparison_notices_a_slightly_wrong_mechanism(wrong: dict[str, float]) -> None:
    comparison = compare_appendix_g(replace(FourBarParameters(), **wrong))
    assert comparison.compared == 844
    assert comparison.agreeing < 700


def test_rates_are_the_derivatives_of_the_angles() -> None:
    parameters, step = FourBarParameters(), 1e-4
    theta = np.linspace(0.0, 6.0, 7)
    before, here, after = (mecqbar(theta + d, parameters) for d in (-step, 0.0, step))
    for link in "23":
        slope = (after[f"theta{link}_rad"] - before[f"theta{link}_rad"]) / (2 * step) * parameters.omega1
        bend = (after[f"omega{link}_rad_s"] - before[f"omega{link}_rad_s"]) / (2 * step) * parameters.omega1
        np.testing.assert_allclose(here[f"omega{link}_rad_s"], slope, rtol=1e-6, atol=1e-5)
        np.testing.assert_allclose(here[f"alpha{link}_rad_s2"], bend, rtol=1e-6, atol=1e-3)


def test_links_that_do_not_meet_are_an_error() -> None:
    with pytest.raises(ValueError, match="cannot be joined at crank angle 180"):
        mecqbar([0.0, np.pi], FourBarParameters(b=0.05, c=0.15))
