"""Laws that hold for any linkage at any speed: by chance, the same in every run."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from fenics_mech import analyse
from fenics_mech.scene.factories import four_bar

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
