"""Forces of the rigid mechanism against virtual work and Newton-Euler equilibrium, for every demo and more machines.

The inertia of the links is integrated here by hand, from the velocities and accelerations of the members' ends, and
shares nothing with the beams' mass matrices.
"""

import numpy as np
import pytest

from fenics_mech.forces.joint_forces import nodal_forces, reactions
from fenics_mech.forces.virtual_work import Forces
from fenics_mech.response.setup import mechanism
from fenics_mech.response.static.quasi_static import solve_static


@pytest.fixture
def solved(moving_machine):
    scene = moving_machine.changed(analysis__sub_intervals=36)
    system = mechanism(scene)
    history = solve_static(system)
    efforts = Forces(scene, system, history).efforts()
    return scene, system.motion, reactions(system, nodal_forces(system, history)), efforts


def cross(a, b):
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def mass_per_length(scene, member):
    """Mass per length rho A (kg/m) of a member of one material, or of plies."""
    section = scene.sections[member.section]
    if member.material is None:
        return section.width * sum(ply.thickness * scene.materials[ply.material].density for ply in section.plies)
    return scene.materials[member.material].density * section.area


def lumps(scene, motion, link):
    """Point masses that move as a link does: (mass, inertia, place, velocity, acceleration), the last ``(angles, 2)``.

    A uniform bar has the inertia of a sixth of its mass at each end and two thirds in the middle (Simpson's rule, exact
    for the products of fields that are linear along it).
    """
    body = scene.links[link]
    found = []
    for member in body.members.values():
        first, second = (np.array(body.points[end]) for end in member.ends)
        mass = mass_per_length(scene, member) * np.linalg.norm(second - first)
        found += [
            (share * mass, 0.0, place)
            for share, place in ((1 / 6, first), (4 / 6, (first + second) / 2), (1 / 6, second))
        ]
    if body.rigid is not None:
        found.append((body.rigid.mass, body.rigid.inertia, body.rigid.centre))
    for mass in scene.masses.values():
        if mass.at.split(".")[0] == link:
            found.append((mass.mass, mass.inertia, scene.point(mass.at)[1]))
    return [(mass, inertia, *motion.of_point(link, tuple(place))) for mass, inertia, place in found]


def energy_rate(scene, motion):
    """Rate of the kinetic energy (W) of the rigid links."""
    total = np.zeros(len(motion.theta))
    for i, link in enumerate(motion.links):
        for mass, inertia, _, velocity, acceleration in lumps(scene, motion, link):
            total += mass * np.sum(velocity * acceleration, axis=1)
            total += inertia * motion.omega[:, i] * motion.alpha[:, i]
    return total


def drive_rates(scene, motion):
    """Rate of each drive (rad/s or m/s), from its law."""
    return {d.joint: scene.cycle_rate * d.jet(motion.theta, scene.cycle_rate).first for d in scene.drives}


def loads_of(scene, motion, found, link):
    """Forces and moments of all joints on a link: (force, moment, where the force acts), arrays over the angles."""
    loads = []
    for name, joint in scene.joints.items():
        bodies = [at.split(".")[0] for at in joint.connect]
        if link not in bodies:
            continue
        sliding = joint.kind in ("slot", "prismatic")
        body, place = scene.point(joint.connect[1] if sliding else joint.connect[bodies.index(link)])
        where = (
            np.array(place) if body == "ground" else motion.of_point(body, place)[0]
        )  # a slot's force acts at its pin
        values = []
        for rows in (2, 1):
            held = {b: found[name, b, rows] for b in bodies if (name, b, rows) in found}
            values.append(held[link] if link in held else -sum(held.values()))
        force, moment = values
        loads.append((force, np.zeros(len(force)) if np.isscalar(moment) else moment[:, 0], where))
    return loads


def test_power_of_the_drives_is_the_rate_of_kinetic_energy(solved):
    scene, motion, _, efforts = solved
    rate = energy_rate(scene, motion)
    power = sum(efforts[joint] * speed for joint, speed in drive_rates(scene, motion).items())
    assert np.abs(power - rate).max() < 1e-10 * np.abs(rate).max()


def test_every_link_is_in_equilibrium(solved):
    scene, motion, found, _ = solved
    for i, link in enumerate(motion.links):
        force, moment = np.zeros((len(motion.theta), 2)), np.zeros(len(motion.theta))
        loads = loads_of(scene, motion, found, link)
        largest, turning = (
            max(np.abs(value).max() for value in part)
            for part in zip(*[(f, m + cross(where, f)) for f, m, where in loads])
        )
        for f, m, where in loads:
            force, moment = force + f, moment + m + cross(where, f)
        for mass, inertia, place, _, acceleration in lumps(scene, motion, link):
            force = force - mass * acceleration
            moment = moment - mass * cross(place, acceleration) - inertia * motion.alpha[:, i]
        assert np.abs(force).max() < 1e-10 * largest, link
        assert np.abs(moment).max() < 1e-10 * turning, link
