"""Element matrices, meshes and their export."""

import gmsh
import meshio
import numpy as np
import pytest

from fenics_mech.beams.element_matrices import assemble_beams
from fenics_mech.beams.export import plane_mesh, write_mesh
from fenics_mech.beams.mesh import mesh_scene
from fenics_mech.errors import ResultError
from fenics_mech.machine.linkage import solve_motion
from fenics_mech.scene.factories import seed_four_bar
from tests.validation.reference.nine_element import element_mass, element_stiffness

UNEVEN = {"stations": (0, 0.07, 0.5, 0.55, 1)}


@pytest.mark.parametrize("mesh", [{"elements": 3}, {"elements": 4, "grading": 1.7}, UNEVEN])
def test_element_matrices_are_those_typed_by_hand(mesh):
    scene = seed_four_bar(mesh=mesh)
    beams = assemble_beams(scene, mesh_scene(scene))
    for i, h in enumerate(beams.mesh.cell_length):
        section = list(scene.sections.values())[beams.mesh.cell_member[i]]
        by_hand = element_mass(2714 * section.area, h), element_stiffness(71e9, section.area, section.inertia, h)
        for found, expected in zip((beams.element_mass[i], beams.element_stiffness[i]), by_hand):
            # relative to each row's own size: the axial entries dwarf the bending ones
            scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
            assert np.abs((found - expected) / scale).max() < 1e-11


@pytest.mark.parametrize("mesh", [{"elements": 5}, {"elements": 6, "grading": 0.8}, UNEVEN])
def test_nodes_stand_where_they_were_asked_for(mesh):
    scene = seed_four_bar(mesh=mesh)
    found = mesh_scene(scene)
    for i, length in enumerate(found.member_length):
        ends = (found.cell_start + found.cell_length)[found.cell_member == i] / length
        ratio = found.cell_length[found.cell_member == i]
        if "stations" in mesh:
            assert np.allclose(ends, mesh["stations"][1:], rtol=0, atol=1e-14)
        else:
            assert np.allclose(ratio[1:] / ratio[:-1], mesh.get("grading", 1.0), rtol=1e-11)
        assert ends[-1] == pytest.approx(1, abs=1e-14)


def test_a_member_may_have_its_own_mesh():
    scene = seed_four_bar()
    members = scene.model_dump()["links"]["coupler"]["members"]
    members["AB"]["mesh"] = {"elements": 7}
    mesh = mesh_scene(scene.changed(links__coupler__members=members))
    assert np.bincount(mesh.cell_member).tolist() == [3, 7, 3]


def test_gmsh_is_left_as_it_was_found(seed):
    gmsh.initialize(interruptible=False)
    try:
        gmsh.model.add("mine")
        mesh_scene(seed)
        assert gmsh.isInitialized()
        assert gmsh.model.getCurrent() == "mine"
    finally:
        gmsh.finalize()
    mesh_scene(seed)
    assert not gmsh.isInitialized()


def test_rigid_link_motion_costs_no_energy_and_has_its_mass(seed):
    beams = assemble_beams(seed, mesh_scene(seed))
    mesh = beams.mesh
    k, m = beams.stiffness.toarray(), beams.mass.toarray()
    rows = mesh.node_link == 0  # the crank with the mass at A
    x = mesh.node_xy[:, 0]
    zero, one = np.zeros_like(x), rows.astype(float)
    shift = np.stack([zero, one, zero], 1).ravel()
    turn = np.stack([zero, one * x, one], 1).ravel()
    assert np.abs(k @ shift).max() < 1e-9 * np.abs(k).max()
    assert np.abs(k @ turn).max() < 1e-9 * np.abs(k).max()
    crank = 2714 * 1.07e-4 * 0.10795
    assert shift @ m @ shift == pytest.approx(crank + 0.0452, rel=1e-12)
    assert turn @ m @ turn == pytest.approx((crank / 3 + 0.0452) * 0.10795**2, rel=1e-12)


@pytest.mark.parametrize("ending", [".msh", ".vtu", ".xdmf"])
def test_export_can_be_read_back(seed, tmp_path, ending):
    mesh = mesh_scene(seed)
    path = tmp_path / f"mesh{ending}"
    write_mesh(plane_mesh(seed.links, seed.joints, mesh, solve_motion(seed, np.zeros(1))), path)
    read = meshio.read(path)
    lines = read.cells_dict["line"]
    assert len(lines) == 9
    lengths = np.linalg.norm(read.points[lines[:, 1]] - read.points[lines[:, 0]], axis=1)
    assert np.allclose(lengths, mesh.cell_length, rtol=1e-6)
    members = read.cell_data_dict["gmsh:physical" if ending == ".msh" else "member"]["line"]
    assert members.tolist() == [1] * 3 + [2] * 3 + [3] * 3
    if ending == ".msh":
        assert set(read.field_data) == {"crank", "coupler", "follower", "ground O", "joint A", "joint B", "ground C"}
        at_b = read.cells_dict["vertex"][read.cell_data_dict["gmsh:physical"]["vertex"] == 3].ravel()
    else:
        at_b = np.flatnonzero(read.point_data["point"] == 3)
    assert len(at_b) == 2
    assert np.allclose(*read.points[at_b], atol=1e-9)


def test_unknown_mesh_format_is_refused(seed, tmp_path):
    plane = plane_mesh(seed.links, seed.joints, mesh_scene(seed), solve_motion(seed, np.zeros(1)))
    with pytest.raises(ResultError, match=r"\.stl"):
        write_mesh(plane, tmp_path / "mesh.stl")
