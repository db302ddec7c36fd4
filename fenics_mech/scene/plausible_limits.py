"""What machines have: limits beyond which a number of a scene is hardly meant."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from fenics_mech._constants import TURN


@dataclass(frozen=True)
class Plausible:
    """Limits of what machines have."""

    lightest: float = 10.0  # density (kg/m^3): foam
    heaviest: float = 23_000.0  # kg/m^3: osmium has 22,600
    softest: float = 1e5  # modulus (Pa): soft rubber
    stiffest: float = 1.5e12  # Pa: diamond has 1.2e12
    slowest: float = 300.0  # sqrt(E/rho) (m/s): rubber is below
    fastest: float = 20_000.0  # m/s: diamond has 18,000
    least_shear: float = 1e-3  # shear modulus over Young's: fibre composites have 0.02
    largest_shear: float = 1.0  # the same: isotropic materials have at most 0.5
    weakest: float = 1e-5  # strength over the modulus: concrete has 1e-4
    strongest: float = 1e11  # strength (Pa): carbon nanotubes have 6e10
    thinnest: float = 1e-4  # height of a section over the member's length: foil of 0.1 mm in 1 m
    thinnest_in_mm: float = 1e-4  # height (m) that millimetres without a unit may have meant
    highest: float = 1.0  # the same: a beam is longer than high
    narrowest: float = 1e-5  # width over the length: a wire
    widest: float = 5.0  # the same: a flap is wide
    farthest_fibre: float = 10.0  # radii of gyration: a T has 3
    farthest_offset: float = 30.0  # of a section from its pins, over its outer fibre: brackets have up to about 10
    short_arm: float = 0.5  # length of a member that is made rigid, over the longest that bends
    longest: float = 100.0  # length of a member (m): jibs of tower cranes have 80
    least_alike: float = 1 / 200  # shortest member over the next, which may be a stub
    most_alike: float = 50.0  # longest member over the next
    heaviest_point: float = 300.0  # mass at a point over that of all members
    largest_inertia: float = 10.0  # over mass times length^2: beyond 1 the mass is beyond the linkage's reach
    weak_gravity: float = 0.1  # m/s^2
    strong_gravity: float = 100.0  # m/s^2
    largest_angle: float = 2 * TURN  # rad
    largest_whole: float = TURN  # rad, of a whole number, which degrees with their unit never become
    longest_stroke: float = 10.0  # over the longest member
    fastest_tip: float = 340.0  # m/s: the speed of sound in air
    largest_strain: float = 0.01  # metals yield at 0.001 to 0.01
    largest_ratio: float = 0.2  # structures have 0.001 to 0.1
    longest_retardation: float = 0.5  # times the drive's rate: half of it is the damping ratio at that rate
    largest_drag: float = 20.0  # over the drive's rate: then it stops vibrations that are ten times as fast
    largest_tolerance: float = 0.1  # of any quantity
    longest_run_up: float = 1000.0  # cycles
    longest_spring: float = 10.0  # free length over the size of the linkage
    least_nominal: float = 300.0  # rad/s: below it are few speeds of motors in rpm, and many machines in rad/s
    step_of_nominal: float = 50.0  # of speeds of motors and machines in rpm: 750, 1450, 2850


USUAL = Plausible()
Found = Iterator[tuple[str, str]]  # places in a scene, and what is found there


def likely(value: float, si: str, units: Sequence[tuple[str, float]], low: float, high: float) -> str:
    """Say in which unit (name, size in SI; no name: converted twice) a number in SI is within limits in SI."""
    for unit, factor in units:
        if low <= abs(value) * factor <= high:
            return f": {f'{value:.6g} {unit} = ' if unit else ''}{value * factor:.4g} {si} is likely meant"
    return ""
