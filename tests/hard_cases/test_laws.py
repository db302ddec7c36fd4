"""Laws that hold for any linkage at any speed: by chance, the same in every run."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from fenics_mech import analyse
from fenics_mech.scene.factories import four_bar
from tests.common import response_of

FEW = settings(max_examples=4, derandomize=True, deadline=None)
BAR = {"area": 4e-5, "inertia": 9e-12, "fibre": 8e-4}
MATERIAL = {"modulus": 71e9, "density": 2714.0}
LENGTHS = st.tuples(st.floats(0.05, 0.12), st.floats(0.2, 0.35), st.floats(0.2, 0.35), st.floats(0.2, 0.35)).filter(
    lambda sizes: sizes[0] + max(sizes) < 0.95 * (sum(sizes) - sizes[0] - max(sizes))
)  # the crank is shortest and turns, away from change points


def linkage(lengths, speed=20.0, scale=1.0, modulus=71e9, **rest):
    names = ("crank", "coupler", "follower", "ground")
    section = {"area": 4e-5 * scale**2, "inertia": 9e-12 * scale**4, "fibre": 8e-4 * scale}
    analysis = {"sub_intervals": 24, "stations": 3, "allow_large": True} | rest.pop("analysis", {})
    return four_bar(
        **{name: scale * size for name, size in zip(names, lengths)},
        sections=[section] * 3,
        material=MATERIAL | {"modulus": modulus},
        speed=speed,
        analysis=analysis,
        **rest,
    )


@FEW
@given(LENGTHS, st.floats(0.1, 100.0), st.floats(1e-3, 1e3))
def test_quasi_static_strains_grow_with_the_square_of_speed_and_size(lengths, speed, scale):
    """Stress is density x (speed x length)^2 times a number of the shape."""
    still = {"method": "quasi-static"}
    base = analyse(linkage(lengths, 1.0, analysis=still)).data["strain"]
    other = analyse(linkage(lengths, speed, scale, modulus=3 * 71e9, analysis=still)).data["strain"]
    factor = (speed * scale) ** 2 / 3
    assert np.abs(other - factor * base).max() < 1e-7 * factor * np.abs(base).max()


@FEW
@given(LENGTHS, st.floats(5.0, 25.0))
def test_undamped_motion_runs_backwards_too(lengths, speed):
    """(5.1) without damping knows no direction of time: the crank turned the other way passes the same states."""
    chosen = {"sub_intervals": 72, "solver": "collocation", "scheme": "gauss", "stability": False, "allow_coarse": True}
    ahead, back = (response_of(linkage(lengths, v, analysis=chosen)).data for v in (speed, -speed))
    turned = np.roll(
        back["strain"].to_numpy()[::-1], 1, axis=0
    )  # drive angles 0, -h, -2h ... in the order of the first
    theta = np.roll(back["theta"].to_numpy()[::-1], 1)
    assert np.cos(theta - ahead["theta"].to_numpy()).min() > 1 - 1e-12
    bound = 1e-10 * max(1.0, ahead.attrs["condition"])
    assert np.abs(turned - ahead["strain"].to_numpy()).max() < bound * np.abs(turned).max()
