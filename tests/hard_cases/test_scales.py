"""Stiffnesses, masses and units far apart.

Hard: entries of one matrix that differ by up to 1e12 or more; numbers that are far from 1 because the machine is of a
millionth of a metre, or because its units are. Right: a member as good as rigid gives the answer of the limit, linearly
in its compliance; tiny masses that of none; and a machine scaled by a similarity law the same strains, whatever its
units of length, time and mass, up to 1e9 and 1e27.
"""

import numpy as np
import pytest

from fenics_mech import analyse
from fenics_mech.errors import SolverError, UnresolvedError
from fenics_mech.scene import Scene
from fenics_mech.scene.factories import four_bar, seed_four_bar
from tests.common import response_of
from tests.effects import strips
from tests.effects.test_large_rotations import tip_of

INCH = 0.0254
WAYS = {
    "quasi-static": ({"method": "quasi-static"}, {}),
    "sub-intervals": ({"solver": "sub-intervals"}, {"damping": {"ratio": 0.02}}),
    "modal damping": (
        {"solver": "collocation", "allow_coarse": True, "sub_intervals": 48},
        {"damping": {"ratio": (0.02, 0.03)}},
    ),
    "material damping": (
        {"solver": "collocation", "sub_intervals": 96},
        {"damping": {"material": 1e-4}, "effects": ("coupling",)},
    ),
    "harmonics": (
        {"solver": "harmonic-balance", "sub_intervals": 124, "harmonics": 30, "stability": False},
        {"damping": {"ratio": 0.5}},
    ),
    "in time": ({"method": "transient", "cycles": 1, "settled": 0.0}, {"damping": {"ratio": 0.02}}),
    "nonlinear": (
        {"solver": "collocation", "sub_intervals": 48, "allow_coarse": True},
        {"damping": {"ratio": 0.05}, "effects": ("coupling", "large-rotations")},
    ),
}


def options(way, **more):
    """The analysis and the rest of a scene that is solved one way."""
    analysis, rest = WAYS[way]
    return {"analysis": {"sub_intervals": 72, "stations": 5, "modes": 3, "allow_coarse": True} | analysis | more} | rest


def stiffened(factor, way):
    """The seed four-bar with a crank so many times as stiff, which has no less mass."""
    material = {"modulus": 71e9 * factor, "density": 2714.0}
    scene = seed_four_bar(**options(way, stability=False))
    return scene.changed(materials__stiff=material, links__crank__members__OA__material="stiff")


def strains(scene):
    return response_of(scene).data["strain"].sel(member=["coupler", "follower"])


@pytest.mark.slow
@pytest.mark.parametrize("way", ["quasi-static", "sub-intervals", "modal damping", "material damping", "in time"])
@pytest.mark.xfail(reason="steps in time are 5e-4 apart at stiffnesses of 1e6 and 1e10")
def test_a_crank_as_good_as_rigid(way):
    """The strains elsewhere go to a limit as 1/stiffness. Damped by ratio, collocation was 1e-3 off at 1e8."""
    at = {factor: strains(stiffened(factor, way)).to_numpy() for factor in (1e3, 1e6, 1e10)}
    size = np.abs(at[1e10]).max()
    slope = 1e3 * np.abs(at[1e3] - at[1e10]).max() / size
    bound = 2e-5 if way == "in time" else 1e-10  # time steps are chosen anew; and rounding
    assert slope < 1e3
    assert np.abs(at[1e6] - at[1e10]).max() < (2e-6 * slope + bound) * size


@pytest.mark.parametrize("way", ["quasi-static", "sub-intervals", "material damping"])
def test_a_mass_of_nearly_nothing_is_none(way):
    base = seed_four_bar(**options(way)).changed(masses__A__mass=0.0, masses__B__mass=0.0)
    nearly = base.changed(masses__A__mass=1e-15, masses__B__mass=1e-15)
    assert np.abs(strains(nearly) - strains(base)).max() < 1e-9 * np.abs(strains(base)).max()


@pytest.mark.parametrize("mass", [1e3, 1e6, 1e9])
def test_a_huge_mass_strains_its_crank_alone(mass):
    """Quasi-statically, by its pull: the rest differs by the rounding of that, 1e-16 m/(the links' mass); 3.2e-13."""
    base = seed_four_bar(**options("quasi-static", allow_large=True))
    heavy = analyse(base.changed(masses__A__mass=mass)).data
    assert np.abs(heavy["strain"] - analyse(base).data["strain"]).sel(member=["coupler", "follower"]).max() < (
        5e-13 * mass * np.abs(heavy["strain"].sel(member="coupler")).max()
    )
    pull = mass * 4.25 * INCH * 32.3**2
    found = heavy["axial_force"].sel(member="crank").to_numpy()
    assert found == pytest.approx(np.full_like(found, pull), rel=100 / mass)


@pytest.mark.parametrize("way", ["quasi-static", "material damping"])
def test_slenderness_of_a_million(way):
    """Moments and strains go to a limit as 1/(EA); length over radius of gyration goes from 2e4 to 6e5, 6e6 and 2e7."""

    def scene_of(factor):
        scene = seed_four_bar(**options(way))
        changes = {"materials__material__modulus": 71e9 * factor}
        for name in ("crank", "coupler", "follower"):
            section = scene.sections[name]
            inertia = section.inertia / factor
            changes[f"sections__{name}"] = {"area": section.area, "inertia": inertia, "fibre": section.fibre}
        return scene.changed(**changes)

    def slender(factor):
        return strains(scene_of(factor)).to_numpy()

    at = {factor: slender(factor) for factor in (1e3, 1e6)}
    size = np.abs(at[1e6]).max()
    assert np.abs(at[1e3] - at[1e6]).max() < 1e-3 * size  # rounding of 1e-16 times 1e11
    with pytest.raises(SolverError, match="lost to rounding"):  # 10 % off
        slender(1e9)


@pytest.mark.parametrize("law", [(), ("large-rotations",)])
def test_a_stiff_arm_of_fine_elements_takes_no_digits_of_a_static_answer(law):
    """An arm at the tip of a cantilever moves as a whole; by its matrix alone it took 1.5e-3 and 4e-4 of the rotation.

    Source: its closed form F L^2/(2 EI), and Bisshopp and Drucker, Q. Appl. Math. 3 (1945) 272.
    """
    bending = strips.E * strips.INERTIA
    turn, force = (0.3, tip_of(0.3)[0] * bending / strips.L**2) if law else (0.01, 0.02 * bending / strips.L**2)
    given = strips.beam({"O": {"kind": "weld"}}, effects=law, mesh={"elements": 12}).model_dump()
    stiff = {"area": strips.A * 46.4, "inertia": strips.INERTIA * 1e5, "fibre": 0.04}
    member = given["links"]["beam"]["members"]["OB"]
    arm = {"points": {"B": (0, 0), "C": (0, 0.1)}, "members": {"BC": member | {"ends": ("B", "C"), "section": "stiff"}}}
    weld = {"kind": "weld", "connect": ("beam.B", "arm.B")}
    given |= {"links": given["links"] | {"arm": arm}, "sections": given["sections"] | {"stiff": stiff}}
    given |= {"joints": given["joints"] | {"weld": weld}, "loads": {"tip": {"at": "beam.B", "force": (0, force)}}}
    given |= {"points": {"B": {"at": "arm.B"}, "C": {"at": "arm.C"}}}
    data = analyse(Scene.read(given | {"analysis": {"method": "static", "allow_large": True}})).data
    assert data["rotation"].sel(member="beam").item() == pytest.approx(turn, rel=1e-6)  # by the mesh, or rounding
    if law:
        place = data["point_position_bent"][0]
        reach = (place.sel(point="C") - place.sel(point="B")).to_numpy()
        assert reach == pytest.approx([-0.1 * np.sin(turn), 0.1 * np.cos(turn)], abs=1e-7)


def with_stiff_arm(elements, stiffer, effects):
    """A four-bar whose coupler has an arm of a stiffer material, so many elements long."""
    scene = seed_four_bar(damping={"ratio": 0.02}, effects=effects)
    scene = scene.changed(analysis__sub_intervals=240, drive__speed=15.0)
    given = scene.model_dump()
    coupler = given["links"]["coupler"]
    bar = next(iter(coupler["members"].values()))
    coupler["points"] |= {"P": (11 * INCH, 2 * INCH)}
    coupler["members"] |= {"BP": bar | {"ends": ("B", "P"), "material": "stiff", "mesh": {"elements": elements}}}
    given["materials"] |= {"stiff": {"modulus": 71e9 * stiffer, "density": 2714.0}}
    given["masses"] |= {"P": {"at": "coupler.P", "mass": 0.02}}
    return Scene.read(given)


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("effects", [("coupling",), ("coupling", "large-rotations")])
def test_what_rounding_of_stiff_short_elements_takes_is_told(effects):
    """In silence it was 1e-4 with 40 elements of an arm 100 times as stiff. Modes were not found at 1e4 and 24."""
    one = analyse(with_stiff_arm(12, 100.0, effects)).data
    for elements, stiffer in ((40, 100.0), (24, 1e4)) if len(effects) == 1 else ((40, 100.0),):
        base = one if stiffer == 100.0 else analyse(with_stiff_arm(6, stiffer, effects)).data
        fine = analyse(with_stiff_arm(elements, stiffer, effects)).data
        off = np.abs(fine["strain"] - base["strain"]).sel(member=["coupler.AB", "follower"]).max().item()
        told = fine["strain_error"].sel(source="mesh", member=["coupler.AB", "follower"]).max().item()
        more = told - base["strain_error"].sel(source="mesh", member=["coupler.AB", "follower"]).max().item()
        assert 1 < more / off < 10  # measured 1.5 to 3.1; what rounding takes differs between machines
    with pytest.raises(UnresolvedError, match=r"rounding takes .* as member 'coupler\.BP' has many elements"):
        analyse(with_stiff_arm(40, 1e5, effects[:1]))


def scaled(length, time, mass, **rest):
    """The seed four-bar with its numbers in other units, of so many to the SI unit."""
    strip = {"area": 0.406e-4 * length**2, "inertia": 8.67e-12 * length**4, "fibre": 0.8e-3 * length}
    crank = {"area": 1.07e-4 * length**2, "inertia": 1.62e-10 * length**4, "fibre": 2.12e-3 * length}
    inches = {"crank": 4.25, "coupler": 11.0, "follower": 10.65, "ground": 10.0}
    rest |= {"damping": rest["damping"] | ({"material": 1e-4 * time} if "material" in rest["damping"] else {})}
    return four_bar(
        **{name: size * INCH * length for name, size in inches.items()},
        sections=(crank, strip, strip),
        material={"modulus": 71e9 * mass / length / time**2, "density": 2714 * mass / length**3},
        speed=32.3 / time,
        masses=(0.0452 * mass, 0.03755 * mass),
        **rest,
    )


UNITS = {
    "mm-t-s": (1e3, 1, 1e-3),
    "in-lbf-s": (1 / INCH, 1, 1 / 175.126835),
    "km-year-kg": (1e-3, 3.2e-8, 1),
    "micrometre and microsecond": (1e-6, 1e-6, 1e-18),
    "nanometre, nanosecond and yoctogram": (1e-9, 1e-9, 1e-25),
    "planet": (1e9, 1e4, 1e27),
}
SLOW = ("modal damping", "harmonics", "in time", "nonlinear")


@pytest.mark.slow
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.xfail(reason="1e-3 with ratios and in time, and 2e-2 with harmonics, are left between units")
def test_similar_machines_have_the_same_strains(way):
    """Joint forces, frequencies and multipliers follow. A machine of 1e-6 m was refused, or lost its multipliers."""
    rest = options(way) if way != "quasi-static" else options(way) | {"damping": {}}
    base = response_of(scaled(1, 1, 1, **rest)).data
    names = ("micrometre and microsecond", "planet") if way in SLOW else UNITS
    for length, time, mass in map(UNITS.__getitem__, names):
        data = response_of(scaled(length, time, mass, **rest)).data
        force = mass * length / time**2
        pairs = {"strain": 1, "joint_force": force, "frequency": 1 / time, "multiplier": 1, "growth_rate": 1 / time}
        for name, unit in pairs.items():
            if name in base:
                off = np.abs(data[name].to_numpy() / unit - base[name].to_numpy()).max()
                # rounding, also of differences; 2e-3 under exact strains and ratios of 5 % in the smallest unit
                assert off < (5e-3 if way == "nonlinear" else 2e-5) * np.abs(base[name]).max(), name


def lift(size):
    """A boom that a piston in a barrel raises, with all lengths so many times as large."""

    def link(first, second, start, end, angle):
        ends = {first: (start * size, 0), second: (end * size, 0)}
        members = {"bar": {"ends": (first, second), "section": "bar", "material": "steel"}}
        return {"points": ends, "members": members, "angle": angle}

    return Scene.read(
        {
            "materials": {"steel": {"modulus": 207e9, "density": 7800 / size**2}},
            "sections": {"bar": {"shape": "rectangle", "width": 0.02 * size, "height": 0.012 * size}},
            "ground": {"points": {"O": (0, 0), "C": (0.2 * size, -0.05 * size)}},
            "links": {
                "boom": link("O", "A", 0, 0.25, 0.6),
                "barrel": link("C", "E", 0, 0.18, 1.6),
                "piston": link("S", "A", -0.12, 0, 1.6),
            },
            "joints": {
                "O": {"connect": ("ground.O", "boom.O")},
                "C": {"connect": ("ground.C", "barrel.C")},
                "A": {"connect": ("piston.A", "boom.A")},
                "P": {"kind": "prismatic", "connect": ("barrel.C", "piston.S"), "member": "bar"},
            },
            "drive": {
                "joint": "P",
                "law": {
                    "kind": "harmonics",
                    "mean": 0.0913 * size,
                    "cosine": (0.02 * size,),
                    "sine": (0, 0.005 * size),
                },
                "period": 0.5,
            },
            "effects": ("coupling",),
            "damping": {"ratio": 0.03},
            "mesh": {"elements": 2},
            "analysis": {"sub_intervals": 48, "stations": 5, "allow_coarse": True},
        }
    )


@pytest.mark.slow
def test_similar_pistons_in_barrels_have_the_same_strains():
    """Slopes of a barrel per metre were weighed against displacements: one of 2 m was refused."""
    small, large = (response_of(lift(size)).data["strain"].to_numpy() for size in (1.0, 10.0))
    assert large == pytest.approx(small, abs=1e-8 * np.abs(small).max())  # rounding over differences: 2e-9
