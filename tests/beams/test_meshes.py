"""Meshes: nodes stand where they were asked for, refinement keeps them, quasi-static strains do not depend on them."""

import numpy as np
import pytest

from fenics_mech import analyse, load
from fenics_mech.beams.element_matrices import assemble_beams
from fenics_mech.beams.export import plane_mesh
from fenics_mech.beams.mesh import mesh_scene
from fenics_mech.errors import SceneError
from fenics_mech.machine.linkage import solve_motion
from fenics_mech.scene import refined
from fenics_mech.scene.factories import seed_four_bar
from fenics_mech.scene.meshing import nodes_of
from tests.common import DEMOS, modes_of

UNIFORM, GRADED, UNEVEN = {"elements": 3}, {"elements": 4, "grading": 1.7}, {"stations": (0, 0.07, 0.5, 0.55, 1)}
MESHES = {"uniform": UNIFORM, "graded": GRADED, "uneven": UNEVEN}
QUASI_STATIC = {"method": "quasi-static", "sub_intervals": 12, "allow_coarse": True}


def own_meshes(scene):
    """The scene with a mesh of its own for each of two members; the third takes the scene's."""
    links = scene.model_dump(exclude_unset=True)["links"]
    links["coupler"]["members"]["AB"]["mesh"] = GRADED
    links["follower"]["members"]["CB"]["mesh"] = UNEVEN
    return scene.changed(links=links, mesh={"elements": 2})


def places(mesh, member):
    """Nodes along a member (m)."""
    here = mesh.cell_member == member
    return np.append(mesh.cell_start[here], mesh.member_length[member])


def test_graded_nodes_by_the_geometric_series():
    nodes = nodes_of(seed_four_bar(mesh=GRADED).mesh)
    expected = [(1.7**i - 1) / (1.7**4 - 1) for i in range(5)]
    assert np.allclose(nodes, expected, rtol=0, atol=1e-15)


def test_each_member_has_the_nodes_that_it_asks_for():
    mesh = mesh_scene(own_meshes(seed_four_bar()))
    graded = [(1.7**i - 1) / (1.7**4 - 1) for i in range(5)]
    for i, expected in enumerate(([0, 0.5, 1], graded, UNEVEN["stations"])):
        assert np.allclose(places(mesh, i) / mesh.member_length[i], expected, rtol=0, atol=1e-14)
    # the ends of elements in the link's frame lie at those places, too
    for i, (a, b) in enumerate(mesh.node_xy[mesh.cell_nodes]):
        along = np.array(
            [np.cos(mesh.member_angle[mesh.cell_member[i]]), np.sin(mesh.member_angle[mesh.cell_member[i]])]
        )
        assert np.allclose([a @ along, b @ along], mesh.cell_start[i] + np.array([0, mesh.cell_length[i]]), atol=1e-15)


@pytest.mark.parametrize("times", [1, 3])
@pytest.mark.parametrize("make", [*MESHES, "per member"])
def test_refinement_keeps_the_nodes_and_halves(make, times):
    scene = own_meshes(seed_four_bar()) if make == "per member" else seed_four_bar(mesh=MESHES[make])
    coarse, fine = mesh_scene(scene), mesh_scene(refined(scene, times))
    assert len(fine.cell) == 2**times * len(coarse.cell)
    for i in range(3):
        before, after = places(coarse, i), places(fine, i)
        assert np.allclose(after[:: 2**times], before, rtol=0, atol=1e-16)
        assert np.allclose(np.diff(after), np.repeat(np.diff(before), 2**times) / 2**times, rtol=1e-11)


def test_refinement_leaves_the_scene_as_it_was():
    scene = seed_four_bar()
    assert refined(scene, 0) == scene
    assert refined(scene, 2) != scene
    assert scene == seed_four_bar()
    assert refined(scene, 1).changed(analysis__modes=3).analysis.modes == 3  # still a scene that can be changed


@pytest.mark.parametrize("times", [-1, 17, 10**9])
def test_refinement_without_sense_is_refused(times):
    with pytest.raises(SceneError, match=r"^mesh: "):
        refined(seed_four_bar(), times)


@pytest.mark.parametrize("make", [*MESHES, "per member"])
def test_quasi_static_strains_do_not_depend_on_the_mesh(make):
    scene = own_meshes(seed_four_bar()) if make == "per member" else seed_four_bar(mesh=MESHES[make])
    one = analyse(seed_four_bar(mesh={"elements": 1}, analysis=QUASI_STATIC)).data
    for times in (0, 1):  # round-off grows with the fourth power of the number of elements: 2e-9 at 2
        found = analyse(refined(scene.changed(analysis=QUASI_STATIC), times)).data
        for name in ("strain", "moment", "joint_force", "deflection"):
            scale = np.abs(one[name].to_numpy()).max()
            # one element spreads uneven inertia along the axis by its cubic: 3.5e-6 of the deflection is its stretch
            within = 1e-5 if name == "deflection" else 1e-9
            assert np.abs(found[name].to_numpy() - one[name].to_numpy()).max() < within * scale


def test_frequencies_of_a_frame_fall_with_refinement():
    # Rayleigh-Ritz: the finer space holds the coarser one, so that no frequency can rise
    scene = load(DEMOS / "stephenson.toml").changed(analysis__sub_intervals=8)
    before, after = (modes_of(s).frequency for s in (scene, refined(scene, 1)))
    lowest, finer = np.sort(before, axis=1)[:, :3], np.sort(after, axis=1)[:, :3]  # which both are followed
    assert (finer <= lowest * (1 + 1e-12)).all()
    assert (finer < lowest * (1 - 1e-6)).any()


def test_nine_hundred_elements_are_one_connected_chain_per_member():
    scene = seed_four_bar(mesh={"elements": 300, "grading": 1.001})
    mesh = mesh_scene(scene)
    assert len(mesh.cell) == 900
    assert len(mesh.node_name) == 903
    assert [mesh.node(name) for name in mesh.node_name] == list(range(903))
    for i in range(3):
        chain = mesh.cell_nodes[mesh.cell_member == i]
        assert (chain[1:, 0] == chain[:-1, 1]).all()
    beams = assemble_beams(scene, mesh)
    turn = np.stack([np.zeros(903), np.ones(903), np.zeros(903)], axis=1).ravel()
    crank = 2714 * 1.07e-4 * 0.10795 + 0.0452
    strips = 2714 * 0.406e-4 * (0.2794 + 0.27051) + 0.03755
    assert turn @ beams.mass.toarray() @ turn == pytest.approx(crank + strips, rel=1e-12)


def test_export_names_the_ground_the_pins_and_other_points():
    scene = load(DEMOS / "quick_return.toml")
    mesh = mesh_scene(scene)
    plane = plane_mesh(scene.links, scene.joints, mesh, solve_motion(scene, np.zeros(1)))
    names = {name for name, (_, dim) in plane.field_data.items() if dim == 0}
    assert names == {"ground O", "ground C", "point A", "joint D", "point E"}
    at = dict(zip(plane.cell_data["gmsh:physical"][1].tolist(), plane.points[plane.cells[1].data[:, 0]].tolist()))
    assert at[int(plane.field_data["ground C"][0])][:2] == pytest.approx(scene.ground.points["C"], abs=1e-12)
