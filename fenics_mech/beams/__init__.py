"""Links as beams: gmsh mesh, broken space, UFL forms, matrices in link axes."""
