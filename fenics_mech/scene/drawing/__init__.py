"""A mechanism drawn in gmsh, or written as lines and named sets for Abaqus, as part of a scene.

A scene file that says ``drawing = "four_bar.geo"`` takes from it the links with their points and members, the ground,
the pins and the mesh. The drawing shows the mechanism assembled at drive angle 0, in the plane z = 0. Its physical
groups say what is what:

- Curves, named "link" or "link.member": the beams of a link. Where they turn a corner, branch, or pass a named point,
  one member ends and the next is welded on. A curve that is not straight becomes a chain of its straight elements. The
  member's axis runs as the curve does. A member of a group "link.member" bears that name, others those of their ends.
- Points, named "joint A" (or just "A"): a pin through all links that have the end of a line there. Links that share
  the point need list it once; coincident points of different links are all listed.
- Points, named "ground O": a pin through the ground and all links that have the end of a line there.
- Points, named "slide B 30": a pin that slides on the ground along a line at 30 degrees from the x axis. One link
  alone has it.
- Points, named "point D": no pin, but a name, for a mass or another kind of joint; one point of each link.

In each of these links the point bears the group's name ("crank.A"), in the ground too ("ground.O"). Other ends are
called p1, p2, ... The elements of the drawing are the elements of the analysis. Curves in no physical group are
construction lines. In an Abaqus file, whose names have no spaces, "joint_A" does for "joint A".

A link's frame has its axes parallel to the drawing's, and its origin in the first of its named points.
"""

from fenics_mech.scene.drawing.data import completed

__all__ = ["completed"]
