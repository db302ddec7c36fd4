"""First steps of Newton's method for the periodic motion, from the rigid motion."""

from fenics_mech.solve import Iterate, Iteration, Path


def iterates(machine, period, steps, count, stiffening):
    """Give some steps; the first, with stresses of all terms at all stages that stiffen, is that of a linear theory."""
    iteration, made = Iteration(machine, Path.of_rest(machine, period, steps, 3), stiffening), []
    for _ in range(count):
        iteration.step()
        t = iteration.path.at(iteration.path.tableau.c)[0].ravel()
        made.append(Iterate(t, iteration.found, iteration.change, iteration.predicted))
    return made
