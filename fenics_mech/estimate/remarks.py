"""What is wrong with a result by more than its estimates of errors say."""

from __future__ import annotations

from fenics_mech.scene import Analysis, Scene
from fenics_mech.scene.sampling import SAMPLING

NO_ESTIMATE = "all errors, as none is estimated there"  # of a point of a sweep without error estimates
UNKNOWN = "what the theory leaves out"  # as results say it where there is no estimate
UNKNOWN_AFTER_CONTACT = "the error of the time steps, which contacts may make as large as the motion itself"
FINER_AFTER_CONTACT = (
    "how far contacts let nearly the same motions part: the error of the time steps is the difference from {} their "
    "tolerance"
)


def after_contacts(analysis: Analysis, share: str = "half") -> str:
    """Say what is not known of the time steps of a motion whose contacts opened."""
    return FINER_AFTER_CONTACT.format(share) if analysis.error_estimates == "contacts" else UNKNOWN_AFTER_CONTACT


def between_points(scene: Scene, count: int, cut: bool = False) -> list[str]:
    """Say what loads and drives do between the points of a cycle."""
    if not count:
        return []
    loads = [
        f"what the factor of the load {name!r} does between positions, which do not see it"
        for name, load in scene.loads.items()
        if not (cut and load.cut_where_needed)
        if load.share_missed(count) > SAMPLING.unresolved or load.enough_angles(count) > count
    ]
    drives = [drive for drive in scene.drives if drive.enough_angles(count, scene.cycle_rate) > count]
    return loads + [f"what the law of the drive at {drive.joint!r} does between positions" for drive in drives]
