"""Energy: what the drive puts into the mechanism in a cycle, damping takes out."""

import numpy as np
import pytest

from fenics_mech._arrays import times
from fenics_mech.analysis import analyse
from fenics_mech.building import mechanism, scene_modes
from fenics_mech.mechanism.equation import Equation
from fenics_mech.recovery.joints import drive_efforts, nodal_forces, reactions
from fenics_mech.steady import by_collocation

QUIET = {"analysis__stability": False, "damping__ratio": 0.0}
EVERYTHING = {
    "gravity": (0.0, -9.81),
    "damping__external": 0.5,
    "loads": {"push": {"at": "follower.B", "force": [1.0, 2.0]}},
}


def power(scene):
    """Mean power of the drive on the bent mechanism, and mean dissipation (W).

    The torque in the results balances forces on the undeformed shape. On the bent one the joints' forces also work on
    ``d(P q)/dt`` at fixed q, and inertia and loads on the turning of the displacement, omega x v.
    """
    system = mechanism(scene)
    _, history = by_collocation(scene, system, scene_modes(scene, system))
    forces, v, rate = nodal_forces(system, history), system.to_links(history.displacement), history.velocity
    _, first, _ = Equation(system).shape
    turned = np.zeros_like(v)
    turned[:, ::3], turned[:, 1::3] = -v[:, 1::3], v[:, ::3]
    omega = system.motion.omega[:, system.link_of_dof]
    torque = drive_efforts(scene, system.motion, reactions(system, forces))["O"]
    inertia = history.inertia - scene.damping.external * rate
    outer = (system.link_mass @ inertia.T + system.link_gyroscopic @ history.turning.T).T - system.applied
    put_in = torque * scene.cycle_rate + np.sum(forces * times(first, history.displacement), axis=1)
    put_in += np.sum(omega * inertia * (system.link_gyroscopic @ v.T).T, axis=1)  # J v by the forms, not by nodes
    put_in += np.sum(omega * history.turning * (system.link_mass @ v.T).T - system.applied * omega * turned, axis=1)
    put_in -= np.sum((forces - outer) * rigid_velocity(system), axis=1)  # bent elements resist rigid rotations
    lost = scene.damping.external * np.sum(rate * (system.link_mass @ rate.T).T, axis=1)
    linear = scene.damping.material * np.sum(rate * (system.link_stiffness @ rate.T).T, axis=1)
    if history.viscous is not None:
        linear += np.sum(rate * (system.link_stiffness @ history.viscous.T).T, axis=1)
    if system.terms.law is not None:
        law = system.terms.law
        stretch = np.einsum("tei,tei->te", law._forces(v[:, law.dofs], rate[:, law.dofs])[1], rate[:, law.dofs])
        straight = np.einsum("ei,tei->te", law.stretching.line, rate[:, law.dofs])
        linear += scene.damping.material * np.sum(law.rigidity * (stretch**2 - straight**2), axis=1)
    return put_in.mean(), (lost + linear).mean()


def rigid_velocity(system):
    """Velocity of the rigid motion in nodal dofs and link axes, ``(angles, nodal dofs)``."""
    mesh, motion = system.beams.mesh, system.motion
    phi, omega, velocity = (a[:, mesh.node_link] for a in (motion.angle, motion.omega, motion.velocity))
    c, s, (x, y) = np.cos(phi), np.sin(phi), mesh.node_xy.T
    along = c * velocity[..., 0] + s * velocity[..., 1] - omega * y
    across = c * velocity[..., 1] - s * velocity[..., 0] + omega * x
    return np.stack([along, across, omega], axis=-1).reshape(len(phi), -1)


@pytest.mark.parametrize(
    ("effects", "rest"),
    [(("coupling",), {}), (("coupling", "moderate-rotations"), {}), (("coupling", "moderate-rotations"), EVERYTHING)],
)
def test_damping_takes_out_what_the_drive_puts_in(seed, effects, rest):
    balance = {}
    for steps in (120, 240):
        changes = QUIET | rest | {"damping__material": 1.339e-4, "analysis__sub_intervals": steps}
        put_in, lost = power(seed.changed(effects=effects, **changes))
        balance[steps] = abs(put_in / lost - 1)
    # 1e-5 at 240 Radau steps, order 5 and more: the identity is exact, only the time scheme is not
    assert balance[240] < 3e-5
    assert balance[240] < balance[120] / 20


def test_modal_damping_takes_out_what_the_drive_puts_in(seed):
    balance = {}
    for steps in (240, 480):
        changes = QUIET | {"damping__ratio": 0.02, "analysis__sub_intervals": steps}
        put_in, lost = power(seed.changed(effects=("coupling",), **changes))
        balance[steps] = abs(put_in / lost - 1)
    # the same; with 2 % of all modes the fast ones die out more slowly, and want smaller steps
    assert balance[480] < 3e-5
    assert balance[480] < balance[240] / 10


def test_truncated_equation_does_not_balance(seed):
    # (5.1) drops terms of the coupling: its solution put into the same balance is off by a tenth and more
    scene = seed.changed(effects=(), damping__material=1.339e-4, analysis__sub_intervals=240, **QUIET)
    system = mechanism(scene)
    _, truncated = by_collocation(scene, system, scene_modes(scene, system))
    whole = mechanism(scene.changed(effects=("coupling",)))
    rate = times(Equation(whole).shape[1], truncated.displacement) + truncated.velocity
    lost = scene.damping.material * np.sum(rate * (system.link_stiffness @ rate.T).T, axis=1)
    torque = drive_efforts(scene, system.motion, reactions(system, nodal_forces(system, truncated)))["O"]
    assert abs(torque.mean() * scene.cycle_rate / lost.mean() - 1) > 0.1


@pytest.mark.parametrize(("effects", "conserves"), [(("coupling",), True), ((), False)])
def test_undamped_disturbances_keep_their_energy_in_the_full_equation_only(seed, effects, conserves):
    # C = M' + skew: the full equation is Hamiltonian, its multipliers lie on the unit circle; those of (5.1) need not
    changes = QUIET | {
        "analysis__stability": True,
        "analysis__allow_unstable": True,
        "analysis__allow_coarse": True,
        "analysis__scheme": "gauss",
    }
    scene = seed.changed(effects=effects, analysis__sub_intervals=360, analysis__solver="collocation", **changes)
    data = analyse(scene).data["multiplier"].to_numpy()
    off = np.abs(np.hypot(*data.T) - 1).max()
    assert (off < 1e-5) == conserves
