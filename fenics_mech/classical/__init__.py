"""The dissertation's own method (Kaminski 1989), chapters 4 and 5: the truncated equation (5.1) of links in their axes.

gmsh meshes the links, dolfinx assembles their matrices from UFL forms on a broken space, and P(theta) joins them by
PETSc's ``P^T A P`` at every position. SLEPc finds the modes there. A PETSc KSP solves the sparse system (5.16) of all
sub-intervals as a whole.
"""
