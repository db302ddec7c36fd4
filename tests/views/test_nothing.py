"""Numbers that are rounding are left out: of a rotor that is balanced, and of powers and errors that are none."""

import re

import pytest

import fenics_mech as fm
from fenics_mech.views.prefixes import largest_force
from fenics_mech.views.summary import summary

ARM, SPEED, DENSITY, AREA = 0.2, 10.0, 7850.0, 1e-4  # m, rad/s, kg/m^3, m^2
SMALL = re.compile(r"\d*\.?\d+e-(1[2-9]|[23]\d)")


def rotor(**changes):
    """Two equal arms on one pin at a steady speed: neither force on the frame nor torque."""
    arms = {name: {"ends": ("O", name), "section": "s", "material": "m"} for name in "AB"}
    scene = {
        "effects": (),
        "materials": {"m": {"modulus": 2e11, "density": DENSITY, "poisson": 0.3}},
        "sections": {"s": {"shape": "rectangle", "width": 0.01, "height": 0.01}},
        "ground": {"points": {"O": (0, 0)}},
        "links": {"rod": {"points": {"O": (0, 0), "A": (ARM, 0), "B": (-ARM, 0)}, "members": arms}},
        "joints": {"O": {"connect": ("ground.O", "rod.O")}},
        "drive": {"joint": "O", "speed": SPEED},
        "analysis": {"method": "quasi-static", "sub_intervals": 36},
    }
    return fm.analyse(fm.Scene.read(scene | changes))


def test_the_scale_of_a_balanced_rotor_is_the_force_in_its_arms():
    """Centrifugal force of an arm at its root: rho A w^2 L^2/2."""
    assert largest_force(rotor()) == pytest.approx(DENSITY * AREA * SPEED**2 * ARM**2 / 2, rel=1e-9)


@pytest.mark.parametrize("effects", [(), ("coupling",)])
def test_a_balanced_rotor_prints_no_rounding(effects):
    found = rotor(effects=effects)
    assert SMALL.findall(str(summary(found))) == []
    told = " ".join(str(summary(found, details=True)).split())
    assert "Mean power over the cycle: none." in told
    assert "imbalance" not in told
    assert "root mean square" not in told


def test_rigid_links_in_balance_print_no_imbalance():
    """A weight of 9.81 N on an arm takes in a turn what it gave, and the drive too."""
    rod = {"points": {"O": (0, 0), "A": (ARM, 0)}, "rigid": {"mass": 1.0, "inertia": 0.01, "centre": (ARM / 2, 0)}}
    told = str(summary(rotor(links={"rod": rod}, gravity=(0, -9.81))))
    assert SMALL.findall(told) == []
    assert "imbalance" not in told


def test_what_is_more_than_rounding_is_told():
    """A torque of friction that a joint law takes is the drive's: 1 mN m at 10 rad/s is 10 mW."""
    law = {"kind": "joint-effort", "joint": "O", "effort": 1e-3}
    rod = {"points": {"O": (0, 0), "A": (ARM, 0)}, "rigid": {"mass": 1.0, "inertia": 0.01, "centre": (ARM / 2, 0)}}
    told = str(summary(rotor(links={"rod": rod}, joint_laws={"law": law})))
    assert "drive -10 mW, efforts 10 mW" in told
