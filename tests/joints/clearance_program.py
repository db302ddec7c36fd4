"""An independent program: slider-crank whose piston pin has a radial clearance, by its two Lagrange equations.

The data are those of Flores et al. (2008). Contacts are found as events, and each is integrated by itself.
"""

import numpy as np
from scipy.integrate import solve_ivp

CRANK, ROD = 0.05, 0.12
ROD_MASS, ROD_INERTIA, PISTON_MASS = 0.21, 2.5e-4, 0.14
SPEED = 5000 * 2 * np.pi / 60
CLEARANCE, BEARING = 0.5e-3, 0.01
STIFFNESS = 4 / (3 * 2 * (1 - 0.3**2) / 207e9) * np.sqrt(BEARING * (BEARING - CLEARANCE) / CLEARANCE)


class ClearanceSliderCrank:
    """Unknown are the angle of the rod and the place of the piston, and their rates."""

    def __init__(self, restitution=0.9, friction=0.0, width=1e-3):
        self.damping = 3 * (1 - restitution**2) / 4  # Lankarani and Nikravesh
        self.friction, self.width, self.speed = friction, width, 0.0  # of no contact yet
        self.peak, self.contacts = 0.0, 0

    def gap(self, t, y):
        """From the rod's pin to the piston's, and its rate."""
        theta = SPEED * t
        pin = np.array([CRANK * np.cos(theta) + ROD * np.cos(y[0]), CRANK * np.sin(theta) + ROD * np.sin(y[0])])
        rate = np.array(
            [
                -CRANK * SPEED * np.sin(theta) - ROD * np.sin(y[0]) * y[2],
                CRANK * SPEED * np.cos(theta) + ROD * np.cos(y[0]) * y[2],
            ]
        )
        return np.array([y[1], 0.0]) - pin, np.array([y[3], 0.0]) - rate

    def depth(self, t, y):
        gap, _ = self.gap(t, y)
        return np.hypot(*gap) - CLEARANCE

    def push(self, t, y):
        """Force on the piston, and moment on the rod about its pin, by the contact."""
        gap, rate = self.gap(t, y)
        size = np.hypot(*gap)
        normal = gap / size
        depth, into = size - CLEARANCE, normal @ rate
        force = STIFFNESS * max(depth, 0.0) ** 1.5 * max(1 + self.damping * into / self.speed, 0.0)
        tangent = np.array([-normal[1], normal[0]])
        sliding = tangent @ rate - y[2] * BEARING  # the journal belongs to the piston, the bearing to the rod
        rubbing = self.friction * force * np.tanh(sliding / self.width)
        return -force * normal - rubbing * tangent, rubbing * BEARING

    def rates(self, t, y, touching):
        force, moment = self.push(t, y) if touching else (np.zeros(2), 0.0)
        theta, s, c = SPEED * t, np.sin(y[0]), np.cos(y[0])
        pin = -CRANK * SPEED**2 * np.array([np.cos(theta), np.sin(theta)])
        on_rod = ROD * (s * force[0] - c * force[1]) + moment - ROD_MASS * ROD / 2 * (-s * pin[0] + c * pin[1])
        return [y[2], y[3], on_rod / (ROD_INERTIA + ROD_MASS * ROD**2 / 4), force[0] / PISTON_MASS]

    def course(self, times, tolerance=1e-11):
        """Angle of the rod and place of the piston at times, from a centred journal at the rate of a tight pin."""
        y, t, touching = np.array([0.0, CRANK + ROD, -CRANK * SPEED / ROD, 0.0]), 0.0, False
        found, left = [], list(times)

        def crossing(t, y, *_):
            return self.depth(t, y)

        crossing.terminal = True
        while left:
            crossing.direction = -1.0 if touching else 1.0
            edges = t, times[-1]
            part = solve_ivp(
                self.rates, edges, y, "DOP853", left, True, crossing, args=(touching,),
                max_step=1e-6 if touching else 1e-5,
                rtol=tolerance, atol=tolerance * np.array([1.0, 0.1, 500.0, 50.0]),
            )  # fmt: skip
            if touching:
                inside = np.linspace(t, part.t_events[0][0] if part.status == 1 else times[-1], 400)
                self.peak = max([self.peak, *(np.hypot(*self.push(at, part.sol(at))[0]) for at in inside)])
            found += list(np.reshape(part.y, (4, -1)).T)
            left = left[len(part.t) :]
            if part.status != 1:
                break
            t, y, touching = part.t_events[0][0], part.y_events[0][0], not touching
            if touching:
                gap, rate = self.gap(t, y)
                self.speed, self.contacts = gap @ rate / np.hypot(*gap), self.contacts + 1
        return np.array(found)
