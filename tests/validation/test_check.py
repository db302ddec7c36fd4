"""What `fenics-mech check` compares holds, and a wrong number would be seen."""

import numpy as np
import pytest

from tests.validation.__main__ import main
from tests.validation.check import CHECKS, _difference


@pytest.mark.parametrize("name", CHECKS)
def test_every_comparison_holds(name):
    findings = CHECKS[name]()
    assert findings
    assert [f for f in findings if not f.holds] == []


def test_a_wrong_number_is_seen():
    assert not _difference("x", np.array([1.0, 2.0 + 1e-8]), np.array([1.0, 2.0]), 1e-9).holds
    assert not _difference("x", np.array([1.0, np.nan]), np.array([1.0, 2.0]), 1e-9).holds


def test_it_reports_844_numbers(capsys):
    assert main() == 0
    assert "844 of 844" in capsys.readouterr().out
