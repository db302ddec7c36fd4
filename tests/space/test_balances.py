"""What must balance in an elastic linkage in space: forces on links, forces at ends of members, work over a cycle."""

import numpy as np
import pytest
from scipy.integrate import simpson

import fenics_mech as fm
from tests.space.machines import ORIGIN, RSSR_A, RSSR_Q, Y, Z, bar, rssr, rssr_ball

SIZES = {"crank": (10e-3, 8e-3), "coupler": (6e-3, 3.5e-3), "rocker": (7e-3, 4e-3)}
GRAVITY = np.array([0.0, 0.0, -9.81])
DENSITY, MODULUS, SHEAR = 2700.0, 70e9, 70e9 / 2.6
TIME = 5e-4  # s, of the material's damping


def elastic(**analysis):
    B = rssr_ball(0.0)
    links = {
        "crank": bar(ORIGIN, RSSR_A, Z, "OA", section="crank", material="aluminium"),
        "coupler": bar(RSSR_A, B, Z, "AB", section="coupler", material="aluminium"),
        "rocker": bar(RSSR_Q, B, Y, "QB", section="rocker", material="aluminium"),
    }
    return rssr(
        links,
        sections={name: {"shape": "rectangle", "height": h, "width": w} for name, (h, w) in SIZES.items()},
        drive={"joint": "O", "speed": 60.0},
        gravity=tuple(GRAVITY),
        damping={"material": TIME},
        mesh={"elements": 4},
        analysis={"positions": 120, "stations": 41, "modes": 0, "error_estimates": False} | analysis,
    )


@pytest.fixture(scope="module")
def data():
    return fm.analyse(elastic()).data


def rate(values):
    """Give the rate of periodic values at even positions, harmonic by harmonic."""
    waves = np.fft.rfft(values, axis=0)
    order = np.arange(len(waves)).reshape(-1, *(1,) * (np.ndim(values) - 1))
    return np.fft.irfft(60j * order * waves, n=len(values), axis=0)


def inertia_of(data, member):
    """Give the force of inertia and weight of a member, by its places ``(positions, 3)`` (N)."""
    place = np.asarray(data["place"].sel(member=member))
    length = drawn_length(member)
    return line_mass(member) * length * simpson(rate(rate(place)) - GRAVITY, x=np.asarray(data["s"]), axis=1)


def line_mass(member):
    return DENSITY * float(np.prod(SIZES[member]))


def drawn_length(member):
    return {"crank": 0.1, "coupler": 0.4, "rocker": 0.25}[member]


@pytest.mark.long
@pytest.mark.parametrize(
    ("member", "first", "last"), [("crank", "O", "A"), ("coupler", "A", "B"), ("rocker", "Q", "B")]
)
def test_forces_of_joints_are_the_inertia_of_the_link(data, member, first, last):
    """A joint's force is that on its second link, the first end of each link here but for the rocker's ball."""
    forces = {name: np.asarray(data["joint_force"].sel(joint=name)) for name in "OABQ"}
    on_link = forces[first] - forces[last] if member != "rocker" else forces["Q"] + forces["B"]
    inertia = inertia_of(data, member)
    assert np.abs(on_link - inertia).max() < 1e-3 * np.abs(inertia).max()


@pytest.mark.long
@pytest.mark.parametrize(
    ("member", "s", "joint", "sign"),
    [("crank", 0.0, "O", -1), ("crank", 1.0, "A", -1), ("coupler", 0.0, "A", -1), ("coupler", 1.0, "B", -1),
     ("rocker", 0.0, "Q", -1), ("rocker", 1.0, "B", 1)],
)  # fmt: skip
def test_forces_at_ends_of_members_are_those_of_their_joints(data, member, s, joint, sign):
    """The section's force is what the further part exerts on the nearer one; so is its moment."""
    at = data.sel(member=member, s=s)
    for name in ("force", "moment"):
        own = np.einsum("tij,tj->ti", np.asarray(at["section_axes"]), np.asarray(at[f"section_{name}"]))
        of_joint = sign * np.asarray(data[f"joint_{name}"].sel(joint=joint))
        if joint == "O" and name == "moment":  # the drive's torque is beside the joint's moment
            of_joint = of_joint - np.outer(data["input_torque"][:, 0], Z)
        size = np.abs(np.asarray(data[f"joint_{name}"])).max()
        np.testing.assert_allclose(own, of_joint, atol=1e-8 * size)


def work_of(stress, stiffness, scale):
    """Give the work of damping in a cycle ``(...)`` (J): stress = k (strain + tau strain')."""
    waves = np.fft.rfft(stress, axis=0) / len(stress)
    order = 60.0 * np.arange(len(waves)).reshape(-1, *(1,) * (np.ndim(stress) - 1))
    strain = waves / stiffness / (1 + 1j * order * TIME)
    power = 2 * stiffness * TIME * np.abs(order * strain) ** 2
    return scale * np.sum(power[1:], axis=0) * 2 * np.pi / 60.0


@pytest.mark.long
def test_the_drive_works_as_much_as_the_material_loses(data):
    """Over a cycle, where energy comes back: axial, both bending and torsion by the forces in the sections."""
    lost = 0.0
    for member, (h, w) in SIZES.items():
        at = data.sel(member=member)
        long, short = max(h, w), min(h, w)
        ratio = short / long
        torsion = long * short**3 * (1 / 3 - 0.21 * ratio * (1 - ratio**4 / 12))  # 0.5 % off, of a small part
        stiff = [MODULUS * h * w, SHEAR * torsion, MODULUS * h * w**3 / 12, MODULUS * w * h**3 / 12]
        parts = [at["section_force"][..., 0], *(at["section_moment"][..., k] for k in range(3))]
        per_length = sum(work_of(np.asarray(f), k, drawn_length(member)) for f, k in zip(parts, stiff))
        lost += simpson(per_length, x=np.asarray(data["s"]))
    work = float(np.mean(data["input_torque"])) * 2 * np.pi
    assert work > 0
    assert work == pytest.approx(lost, rel=1e-3)  # 3e-4; the torque's estimate is 2.5e-4 of a torque of far more work
