"""Estimates of errors by each source against the true ones, from runs without that source."""

import re
from dataclasses import replace

import numpy as np
import pytest

from fenics_mech import load
from fenics_mech.errors import UnresolvedError
from fenics_mech.estimate.accepted_errors import advice
from fenics_mech.estimate.error_sources import Errors
from fenics_mech.estimate.missed_peaks import between_stations
from fenics_mech.estimate.quantities import places_of
from fenics_mech.scene import Scene
from fenics_mech.scene.factories import seed_four_bar
from fenics_mech.scene.joints import joint_names
from tests.common import DEMOS, analysed, response_of, too_coarse
from tests.demos.machines import crane, scene
from tests.effects.strips import beam

EVERY = ("theta", "s", "fibre")
TOLD = pytest.approx(1.9, abs=1.1)  # over true: from 0.8, which misleads nobody, to 3
CHAPTER_5 = {"solver": "sub-intervals", "sub_intervals": 360, "allow_coarse": True}
WHOLE = {"solver": "collocation", "sub_intervals": 80, "allow_coarse": True, "stability": False}


def distance(found, exact):
    """Largest difference of each member's strain, positions of the finer of both thinned out."""
    every = exact.sizes["theta"] // found.sizes["theta"]
    return np.abs(found["strain"] - exact["strain"][::every].to_numpy()).max(EVERY)


def ratio(found, exact, *sources):
    """Estimate over the true error, by member."""
    return (found["strain_error"].sel(source=list(sources)).sum("source") / distance(found, exact)).to_numpy()


def meshed(scene, coarse, fine):
    """A result on a mesh, and the reference on a finer one."""
    return analysed(scene.changed(mesh__elements=coarse)).data, response_of(scene.changed(mesh__elements=fine)).data


def blade(effect, elements):
    """A blade that its weight swings about as it turns, ten times its Euler load along it."""
    return scene(
        {"blade": {"points": {"O": (0, 0), "B": (0.5, 0)}, "ends": ("O", "B")}},
        {"O": {"connect": ("ground.O", "blade.O")}},
        {"joint": "O", "speed": 300.0},
        {"O": (0, 0)},
        effects=("coupling", effect),
        gravity=(0, -100.0),
        mesh={"elements": elements},
        analysis=WHOLE | {"sub_intervals": 24},
    )


@pytest.mark.long
@pytest.mark.parametrize(("effect", "elements"), [("geometric-stiffness", 8), ("large-rotations", 4)])
def test_mesh_under_an_axial_force_that_varies(effect, elements):
    """A blade held straight by its rotation, against 16 elements. Measured 1.0 to 1.1.

    Without the bending by forces that vary it is 0.6 to 0.9, and 0.3 to 0.5 without their moments at the nodes.
    """
    exact = blade(effect, 16)
    coarse = exact.changed(mesh__elements=elements)
    found, exact = analysed(coarse).data, response_of(exact).data
    assert ratio(found, exact, "mesh") == pytest.approx(1.15, abs=0.35)
    assert float(found["error_order"].sel(source="mesh")) == 4


@pytest.mark.parametrize(("effect", "order"), [("geometric-stiffness", 1.9), ("large-rotations", 3)])
def test_order_of_the_mesh_under_an_axial_force_that_varies(effect, order):
    """From 4 to 8 elements. Given axial forces are their mean in each element, which exact strains go beyond."""
    fine, *coarse = (response_of(blade(effect, elements)).data for elements in (16, 4, 8))
    four, eight = (distance(one, fine).item() for one in coarse)
    assert np.log2(four / eight) > order


@pytest.mark.parametrize("elements", [2, 3])
@pytest.mark.parametrize(
    "effects", [(), ("coupling",), ("coupling", "geometric-stiffness"), ("coupling", "large-rotations")]
)
def test_mesh(effects, elements):
    """Against 6 elements a link. Measured 1.0 to 1.5: a load that is not linear is made so with its end moments.

    It is 1.9 with two elements and geometric stiffness, where harmonics may meet a mode that is 6 % off.
    """
    scene = seed_four_bar(effects=effects, damping={"material": 1.34e-4}, analysis=WHOLE)
    found, exact = meshed(scene, elements, 6)
    assert ratio(found, exact, "mesh") == pytest.approx(1.4, abs=0.6)
    assert float(found["error_order"].sel(source="mesh")) == 4


def test_mesh_under_drag():
    """Against 8 elements a link. Measured 0.9 to 1.3, and 0.04 to 0.09 without the drag of what the nodes lack."""
    scene = seed_four_bar(effects=("coupling",), drive__speed=25.0, damping={"external": 2000.0}, analysis=WHOLE)
    scene = scene.changed(analysis__sub_intervals=48)
    coarse = scene.changed(mesh__elements=2)
    found, exact = analysed(coarse).data, response_of(scene.changed(mesh__elements=8)).data
    assert ratio(found, exact, "mesh") == pytest.approx(1.1, abs=0.4)


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.xfail(reason="told over true has not been measured anew in time")
def test_mesh_of_chapter_5_and_in_time():
    """The same error by other solvers, on the same equation: that of collocation, within the error of the modes.

    In time, differences between 80 positions in a cycle tell 0.65 to 0.9 of it.
    """
    scene = seed_four_bar(mesh={"elements": 2}, effects=("coupling",), damping={"material": 1.34e-4}, analysis=WHOLE)
    plain = scene.changed(effects=(), damping={"ratio": 0.02})
    in_time = {"method": "transient", "settled": 1e-5, "allow_coarse": True}
    for case, analysis, near in ((plain, CHAPTER_5, 0.3), (scene, in_time, 0.4)):
        expected = analysed(case).data["strain_error"].sel(source="mesh")
        found = analysed(case.changed(analysis=case.analysis.model_copy(update=WHOLE | analysis))).data
        assert found["strain_error"].sel(source="mesh").to_numpy() == pytest.approx(expected.to_numpy(), rel=near)


@pytest.mark.parametrize(
    ("effects", "analysis"),
    [
        ((), {}),
        (("coupling", "large-rotations"), {}),
    ],
)
def test_mesh_under_a_pin_that_travels(effects, analysis):
    """Against 4 elements a link, an eighth as far off. Measured 1.1 to 1.8, and 0.01 to 0.1 without the pin.

    Differences in time and loads linear between positions told half of it with so few positions.
    """
    scene = load(DEMOS / "quick_return.toml").changed(
        effects=effects, damping={"material": 1e-4}, links__rocker__members__CD__mesh=None
    )
    scene = scene.changed(analysis=WHOLE | {"sub_intervals": 60} | analysis)
    found, exact = meshed(scene, 2, 4)
    assert ratio(found, exact, "mesh") == pytest.approx(1.35, abs=0.65)
    assert float(found["error_order"].sel(source="mesh")) == 3


@pytest.mark.parametrize("effect", ["geometric-stiffness", "large-rotations"])
def test_mesh_under_a_pin_that_travels_in_quasi_statics(effect):
    """Measured 0.85 to 1.05. Of one element, the crank's error by the rocker's mesh is told by half: it is 1e-3."""
    scene = load(DEMOS / "quick_return.toml").changed(
        effects=(effect,),
        links__rocker__members__CD__mesh=None,
        analysis={"method": "quasi-static", "sub_intervals": 12, "allow_coarse": True},
    )
    found, exact = meshed(scene, 2, 12)
    assert ratio(found, exact, "mesh") == TOLD


@pytest.mark.slow
@pytest.mark.parametrize("inertia", ["8e-12*(1 - 0.5*s)**3", "8e-12*(0.4 + 2.4*s*(1 - s))"])
@pytest.mark.parametrize(
    ("effects", "analysis"),
    [(("coupling",), WHOLE), (("coupling", "large-rotations"), WHOLE)],
)
def test_mesh_of_sections_that_vary(effects, analysis, inertia):
    """Against 6 elements a link. Measured 0.78 to 1.42 and then raised; 0.4 to 0.7 without what varies inside."""
    section = {"shape": "variable", "area": "4e-5*(1 - 0.5*s)", "inertia": inertia, "fibre": 8e-4}
    speed, damping = (25.0, {"material": 1.34e-4}) if effects else (32.3, {"ratio": 0.02})
    scene = seed_four_bar(effects=effects, drive__speed=speed, damping=damping, analysis=analysis).changed(
        sections__coupler=section, sections__follower=section
    )
    found, exact = meshed(scene, 3, 6)
    assert ratio(found, exact, "mesh") == pytest.approx(1.4, abs=0.45)  # raised by 1.25


@pytest.mark.slow
@pytest.mark.parametrize(
    ("effects", "analysis"),
    [
        (("coupling",), WHOLE),
        (("coupling", "large-rotations"), WHOLE),
    ],
)
def test_mesh_of_lumped_masses(effects, analysis):
    """Against consistent masses on 8 elements a link. Measured 0.99 to 1.19 before it is raised."""
    scene = seed_four_bar(effects=effects, drive__speed=20.0, damping={"ratio": 0.02}, analysis=analysis)
    found = analysed(scene.changed(effects=(*effects, "lumped-mass"), mesh__elements=4)).data
    finer = response_of(scene.changed(mesh__elements=8)).data
    assert ratio(found, finer, "mesh") == pytest.approx(1.1, abs=0.3)
    assert float(found["error_order"].sel(source="mesh")) == 2


def test_mesh_of_lumped_masses_in_quasi_statics():
    analysis = {"method": "quasi-static", "sub_intervals": 40, "allow_coarse": True}
    found = analysed(seed_four_bar(effects=("lumped-mass",), analysis=analysis)).data
    exact = response_of(seed_four_bar(effects=(), analysis=analysis)).data
    assert ratio(found, exact, "mesh") == pytest.approx(1.1, abs=0.2)


@pytest.mark.parametrize(("elements", "low", "high"), [(1, 0.8, 6), (2, 0.8, 4), (4, 0.8, 4)])
def test_mesh_of_a_clamped_taper(elements, low, high):
    """The moments at both ends by the flexibility of the whole beam, which its elements are stiffer than."""
    section = {"shape": "variable", "area": 4e-5, "inertia": "8e-12*(1 - 0.5*s)**3", "fibre": 8e-4}
    scene = Scene.read(
        {
            "materials": {"it": {"modulus": 71e9, "density": 2714}},
            "sections": {"it": section},
            "ground": {"points": {"O": (0, 0), "G": (0.3, 0)}},
            "links": {
                "beam": {
                    "points": {"A": (0, 0), "B": (0.3, 0)},
                    "members": {"AB": {"ends": ("A", "B"), "section": "it", "material": "it"}},
                }
            },
            "joints": {
                "A": {"kind": "weld", "connect": ("ground.O", "beam.A")},
                "B": {"kind": "weld", "connect": ("ground.G", "beam.B")},
            },
            "loads": {"snow": {"member": "beam", "line": (0, -5.0)}},
            "mesh": {"elements": elements},
            "analysis": {"method": "static", "allow_coarse": True},
        }
    )
    x = (np.arange(100_000) + 0.5) / 100_000  # over the length
    bend = 1 / (1 - 0.5 * x) ** 3
    load = -5.0 * 0.3**2 * x**2 / 2
    ends = np.stack([np.ones_like(x), x])  # neither end turns, nor do they move apart
    moments = np.linalg.solve((ends * bend) @ ends.T, -(ends * bend) @ load)
    found = analysed(scene).data
    s = found["s"].to_numpy()
    exact = moments[0] + moments[1] * s - 5.0 * 0.3**2 * s**2 / 2
    stiffness = 71e9 * 8e-12 * (1 - 0.5 * s) ** 3
    true = np.abs((found["moment"].isel(theta=0, member=0).to_numpy() - exact) / stiffness).max() * 8e-4
    assert low < float(found["strain_error"].sel(source="mesh")[0]) / true < high
    assert float(found["error_order"].sel(source="mesh")) == 4


def test_mesh_is_exact_in_quasi_statics_but_for_axial_forces():
    scene = seed_four_bar(
        drive__speed=45.0, mesh={"elements": 2}, analysis={"method": "quasi-static", "sub_intervals": 40}
    )
    data = analysed(scene).data
    assert data["strain_error"].sel(source="mesh").max() < 1e-9 * np.abs(data["strain"]).max()  # rounding
    pressed = scene.changed(effects=("geometric-stiffness",), analysis__allow_coarse=True)
    found, exact = meshed(pressed, 2, 12)
    assert ratio(found, exact, "mesh")[1:] == TOLD  # the crank only stretches


@pytest.mark.parametrize("effect", ["geometric-stiffness", "large-rotations"])
@pytest.mark.parametrize(("weight", "push"), [((-60.0, 0.0), 0.0), ((200.0, 3.0), 0.0), ((-60.0, 3.0), -0.2)])
def test_mesh_under_weight_along_the_members(effect, weight, push):
    """The weight changes the axial force along each element; a cantilever of two elements, strains and deflections."""

    def bent(elements):
        pushed = {"tip": {"at": "beam.B", "force": (push, 0.02)}}
        return beam(
            {"O": {"kind": "weld"}}, gravity=weight, loads=pushed, effects=(effect,), mesh={"elements": elements}
        )

    found, exact = analysed(bent(2)).data, response_of(bent(32)).data
    assert ratio(found, exact, "mesh") == TOLD
    off = np.linalg.norm(found["deflection"] - exact["deflection"], axis=-1).max()
    assert found["deflection_error"].sel(source="mesh").to_numpy() / off == TOLD


@pytest.mark.slow
@pytest.mark.parametrize(("count", "modes"), [(96, 5), (97, 5)])
def test_sub_intervals_and_modes_of_chapter_5(count, modes):
    """Against five times as many, and three modes more. Measured 1.1 to 3.6, with even and odd numbers."""
    scene = seed_four_bar(analysis=CHAPTER_5 | {"sub_intervals": count, "modes": modes, "allow_ringing": True})
    fine = response_of(scene.changed(analysis__sub_intervals=5 * count, analysis__modes=8)).data
    found = ratio(analysed(scene).data, fine.isel(theta=slice(None, None, 5)), "time", "modes")
    assert (found > 1).all()
    assert (found < 5).all()


@pytest.mark.slow
def test_modes_left_out_without_their_static_answer():
    analysis = CHAPTER_5 | {"modes": 3, "sub_intervals": 96, "static_correction": False, "allow_ringing": True}
    scene = seed_four_bar(analysis=analysis)
    more = {"analysis.sub_intervals": 480, "analysis.modes": 8, "analysis.static_correction": True}
    fine = response_of(scene.changed(more)).data
    found = ratio(analysed(scene).data, fine.isel(theta=slice(None, None, 5)), "time", "modes")
    assert (found > 1).all()
    assert (found < 3).all()


IN_TIME = {"method": "transient", "cycles": 1, "settled": 0, "sub_intervals": 120, "allow_coarse": True}


@pytest.mark.slow
@pytest.mark.parametrize("tolerance", [1e-4, 0.02])
def test_steps_in_time(tolerance):
    """Against steps of a much smaller tolerance, with ratios of modes."""
    scene = seed_four_bar(effects=("coupling",), analysis=IN_TIME | {"time_tolerance": tolerance})
    exact = response_of(scene.changed(analysis__time_tolerance=1e-8)).data
    found = ratio(analysed(scene).data, exact, "time")
    assert (found > 0.7).all()
    assert (found < 10).all()


@pytest.mark.slow
@pytest.mark.parametrize("damping", [{"material": 1.34e-4}, {"ratio": 0.02}])
@pytest.mark.parametrize("start", ["rigid", "static"])
def test_what_is_damped_in_time_does_not_depend_on_the_positions(damping, start):
    """Strains and forces are those of their instants, at which alone a start lets the forces of damping jump."""
    scene = seed_four_bar(damping=damping, effects=("coupling",), analysis=IN_TIME | {"start": start})
    many = analysed(scene.changed(analysis__error_estimates=False)).data.isel(theta=slice(None, None, 10))
    few = analysed(scene.changed(analysis__error_estimates=False, analysis__sub_intervals=12)).data
    for name in ("strain", "stress", "joint_force"):
        known = many[name].to_numpy()
        assert np.abs(few[name].to_numpy() - known).max() < 1e-3 * np.abs(known).max(), name


@pytest.mark.parametrize(("elements", "damping"), [(1, 0.005), (2, 0.002), (3, 0.002)])
def test_mesh_under_a_law_that_is_not_linear_where_little_damps(elements, damping):
    """Against 5 elements. What the error makes of itself is taken at small motions, where the law is linear.

    Measured 0.8 to 2.7. Taken at the size of the error it was 0.002 to 0.005, 1.2 to 2.5 and 0.2 to 0.4.
    """
    scene = seed_four_bar(effects=("coupling", "large-rotations"), damping={"ratio": damping}, analysis=WHOLE)
    scene = scene.changed(analysis__allow_large=True)
    found, exact = meshed(scene, elements, 5)
    told = ratio(found, exact, "mesh")
    assert (told > 0.8).all()
    assert elements == 1 or (told < 3.5).all()  # with one, the error itself is as large as the law allows


def test_mesh_of_one_element_whose_modes_are_far_off():
    """Eigenvalues that one of Arnoldi's bases has and the one before has not are by chance: they made it 90 times.

    The modes are so far off that harmonics of the loads may meet them: measured 2.2 to 5, half of it by these.
    """
    scene = load(DEMOS / "composite_four_bar.toml").changed(effects=("coupling",), damping={"ratio": 0.02})
    scene = scene.changed(mesh__elements=1, analysis=WHOLE | {"sub_intervals": 120})
    found, exact = meshed(scene, 1, 3)
    told = ratio(found, exact, "mesh")
    assert (told > 0.7).all()
    assert (told < 8).all()


def test_what_impulses_do_beyond_the_mesh_is_said_not_to_be_estimated():
    """At mid-span the strain just after a blow grows with the elements; the estimates are 1e-2 of what it changes."""
    hammer = {"at": "coupler@0.5", "angle": 1.0, "impulse": (0, 0.01)}
    scene = seed_four_bar(effects=("coupling", "impulses"), impulses={"hammer": hammer}, analysis=WHOLE)
    result = analysed(scene)
    assert "what impulses put into vibration" in result.data.attrs["not_estimated"]
    assert "not_estimated" not in analysed(seed_four_bar(analysis=WHOLE)).data.attrs


def test_a_peak_of_a_load_that_no_position_sees_is_named():
    """A pulse of 0.1 deg in a factor that is large elsewhere: 8 % off, of which 0.7 % was told."""
    factor = {"kind": "expression", "formula": "sin(theta) + 5*exp(-((theta - 2.0001)/0.001)**2)"}
    scene = seed_four_bar(loads={"p": {"at": "B", "force": (0.0, 2.0), "factor": factor}}, analysis=WHOLE)
    assert "the factor of the load 'p' does between positions" in analysed(scene).data.attrs["not_estimated"]
    wide = scene.changed(loads__p__factor={"kind": "expression", "formula": "sin(theta) + 5*exp(-(theta - 2)**2)"})
    assert "not_estimated" not in analysed(wide).data.attrs


@pytest.mark.slow
def test_chapter_5_sees_a_load_at_positions_only():
    """Collocation sees 93 % of the peak with 1,080 points, chapter 5 86 % with 360, also where the program chose it."""
    factor = {"kind": "expression", "formula": "sin(theta) + 5*exp(-((theta - 2.0001)/0.004)**2)"}
    scene = seed_four_bar(loads={"p": {"at": "B", "force": (0.0, 2.0), "factor": factor}}, analysis=CHAPTER_5)
    assert "not_estimated" in analysed(scene.changed(analysis__solver="auto", analysis__allow_ringing=True)).data.attrs
    whole = scene.changed(analysis__solver="collocation", analysis__stability=False)
    assert "not_estimated" not in analysed(whole).data.attrs


@pytest.mark.long
@pytest.mark.slow
def test_a_torsional_spring_much_stiffer_than_the_mesh():
    """With a ratio its drag goes with the mesh: at 1e6 N m/rad 12 % of the follower's strain, and 0.2 % were told."""
    clamp = {"clamp": {"joint": "C", "stiffness": 1e6}}
    plain = {"solver": "collocation", "stability": False, "sub_intervals": 120}
    stiff = seed_four_bar(effects=("coupling",), springs=clamp, damping={"ratio": 0.02}, analysis=plain)
    with pytest.raises(
        UnresolvedError, match=r"springs.clamp: .* Take up to 8.2e\+02 N m/rad"
    ):  # 30 * 4 * 0.6156/0.0902
        analysed(stiff)
    passed = analysed(stiff.changed(analysis__allow_coarse=True)).data
    assert "torsional spring 'clamp'" in passed.attrs["not_estimated"]
    softer, finer = meshed(stiff.changed(springs__clamp__stiffness=800.0), 3, 6)
    error = np.abs(softer["strain"] - finer["strain"]).max(("theta", "s", "fibre"))
    told = softer["strain_error"].sel(source=["time", "mesh"]).sum("source")
    assert (error < 2 * told).all()
    assert "not_estimated" not in softer.attrs


def test_what_modal_joins_lose_is_named():
    """17 to 59 % off, of which 2 % was told."""
    scene = seed_four_bar(analysis=CHAPTER_5)
    assert "join = 'modal'" in analysed(scene.changed(analysis__join="modal")).data.attrs["not_estimated"]
    assert "join" not in analysed(scene).data.attrs.get("not_estimated", "")


def test_harmonics():
    """Against collocation. The error of a series that is too short is that of the harmonics left out."""
    analysis = WHOLE | {"solver": "harmonic-balance", "sub_intervals": 240, "harmonics": 50}
    scene = seed_four_bar(effects=("coupling",), analysis=analysis)
    exact = response_of(scene.changed(analysis__solver="collocation")).data
    found = ratio(analysed(scene).data, exact, "harmonics")  # told by steps, as they are compared here
    assert found == pytest.approx(1, rel=1e-3)


def test_steps_too_long_for_a_vibration_that_nothing_damps_ask_for_damping(seed):
    free = seed.changed(damping={})
    assert advice(seed, "time", 2.0, 1)[0].startswith("Take at least")
    assert advice(free, "time", 2.0, 1)[0].startswith(
        "State the damping, as nothing damps the vibration, or take at least"
    )
    dampers = {"d": {"joint": "C", "damping": 0.001}}
    assert advice(free.changed(dampers=dampers), "time", 2.0, 1)[0].startswith("Take at least")


def test_too_coarse_a_stated_mesh_is_told_with_what_to_do():
    scene = seed_four_bar(mesh={"elements": 1}, effects=("coupling",), analysis={"sub_intervals": 180})
    assert re.match(r"the elements are too long: .* from the mesh\. Take \S+ times as many elements", too_coarse(scene))


def test_forces_are_refused_where_strains_are_not():
    """Named by joint, and by body where a pin holds more than two."""
    machine = load(DEMOS / "jansen.toml")
    names = joint_names(machine.joints)
    sizes = {
        name: np.full(len(parts), 100.0)
        for name, parts in places_of(machine.members(), machine.joints, machine.drives).items()
    }
    by_quantity = {name: {"mesh": 0.0 * size} for name, size in sizes.items()}
    by_quantity["joint_force"]["mesh"] = 60.0 * (np.array(names) == "BL:left_c")
    errors = Errors(by_quantity, {"mesh": 4.0}, sizes)
    with pytest.raises(
        UnresolvedError, match=r"the elements are too long: the force in joint 'BL:left_c' is .* 60 % of "
    ):
        errors.judge(machine)
    assert errors.too_large
    larger = {name: 2 * size for name, size in sizes.items()}
    assert not replace(errors, measure=larger).too_large


def test_strain_between_stations():
    """A parabola is exact: its vertex at 0.45 is missed by stations at every quarter by (0.05)^2."""
    s = np.linspace(0, 1, 5)
    strain = np.stack([(1 - (s - 0.45) ** 2), s])[None, :, :, None]
    assert between_stations(strain) == pytest.approx([0.05**2, 0], abs=1e-12)


@pytest.mark.parametrize("elements", [3, 12])
def test_what_polynomials_miss_of_a_section(elements):
    """A notch of 0.8 of the section in 8 % of the coupler: what 5 points in an element miss of it is estimated."""
    notch = "(1 - 0.8*exp(-((s - 0.27)/0.05)**2))"
    section = {"shape": "variable", "area": f"4e-5*{notch}", "inertia": f"8e-12*{notch}", "fibre": 8e-4}
    analysis = WHOLE | {"stability": False}
    scene = seed_four_bar(effects=("coupling",), drive__speed=20.0, damping={"ratio": 0.02}, analysis=analysis)
    scene = scene.changed(sections__coupler=section)
    found, exact = meshed(scene, elements, 24)
    # of the coupler; halved elements lack less than 15/16 of the error where they are as long as the notch
    assert ratio(found, exact, "mesh")[1] > 0.6


def test_mesh_under_a_slider_that_passes_nodes():
    """Elements give way under the slider, so that its turn has no kink at nodes. Measured 0.97 and 0.49."""
    scene = crane().changed(analysis=WHOLE | {"sub_intervals": 120})
    found, exact = meshed(scene, 3, 12)
    assert ratio(found, exact, "mesh")[2:] == pytest.approx([1, 0.5], abs=0.2)  # of the barrel and the piston
    assert (distance(found, exact) < 2e-3 * np.abs(found["strain"]).max(EVERY)).all()  # measured 9e-4


def test_error_of_the_mesh_where_members_bend_far():
    """What a motion lacks is linear for little of it only. The true errors are 0.014 to 0.036."""
    scene = seed_four_bar(
        drive__speed=45.93, effects=("coupling", "large-rotations"), analysis=WHOLE | {"sub_intervals": 90}
    )
    found = analysed(scene).data
    told = found["strain_error"].sel(source="mesh") / np.abs(found["strain"]).max(EVERY)
    assert (told > 0.01).all()
    assert (told < 0.06).all()
