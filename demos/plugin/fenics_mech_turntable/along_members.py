"""A plot: the axial force of each member along it, at the drive angle where it is largest."""

from matplotlib.figure import Figure

from fenics_mech.recovery import Result


def axial_force(result: Result) -> Figure | None:
    """Draw the axial forces; None where no link bends."""
    if "axial_force" not in result.data:
        return None
    figure = Figure(figsize=(7, 4), layout="constrained")
    axes = figure.subplots()
    for name in result.data["member"].to_numpy():
        force = result.data["axial_force"].sel(member=name)
        largest = force.isel(theta=int(abs(force).max("s").argmax("theta")))
        axes.plot(force["s"], largest, label=str(name))
    axes.set(xlabel="place along the member, s", ylabel="axial force (N)")
    axes.legend()
    return figure
