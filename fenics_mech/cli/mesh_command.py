"""`fenics-mech mesh`."""

from __future__ import annotations

from pathlib import Path

from fenics_mech._console import loading, make_folder, tell, tell_written
from fenics_mech.cli.common import OutFolder, Refine, SceneFile


def mesh(scene: SceneFile, folder: OutFolder = Path("out"), refine: Refine = 0) -> None:
    """Mesh a scene: write mesh.msh, mesh.vtu and mesh.xdmf at drive angle 0."""
    import numpy as np  # noqa: PLC0415

    with loading():
        from fenics_mech._files import write_whole  # noqa: PLC0415
        from fenics_mech.beams.export import FORMATS, plane_mesh, write_mesh  # noqa: PLC0415
        from fenics_mech.beams.mesh import mesh_scene  # noqa: PLC0415
        from fenics_mech.effects import active, loads_at_nodes  # noqa: PLC0415
        from fenics_mech.machine.linkage import solve_motion  # noqa: PLC0415
        from fenics_mech.scene import refined  # noqa: PLC0415
        from fenics_mech.scene.files import load_planar  # noqa: PLC0415

    loaded = refined(load_planar(scene), refine)
    make_folder(folder)
    beams = mesh_scene(loaded, loads_at_nodes(active(loaded)))
    plane = plane_mesh(loaded.links, loaded.joints, beams, solve_motion(loaded, np.zeros(1)))
    for ending in FORMATS:
        write_whole(folder / f"mesh{ending}", lambda temporary: write_mesh(plane, temporary))
    tell(f"{len(beams.cell)} elements, {len(beams.node_name)} nodes, {len(beams.members)} members")
    tell_written((Path(f"mesh{ending}") for ending in FORMATS), folder)
