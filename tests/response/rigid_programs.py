"""Independent programs for rigid linkages, from their Lagrange equations, integrated by an explicit rule of order 8."""

import numpy as np
from scipy.integrate import solve_ivp

G = 9.81


def chain_of_bars(count, end, angles=None, tolerance=1e-13):
    """Angles of a chain of equal bars (1 m, 1 kg) that hang on the ground, from rest along X; absolute, at the end."""
    i = np.arange(count)
    share = count - np.maximum.outer(i, i) - 0.5  # of m L^2 in the kinetic energy of two bars' rates
    share[i, i] = count - i - 1 + 1 / 3
    weight = G * (count - i - 0.5)

    def rates(_, y):
        angle, omega = y[:count], y[count:]
        between = angle[:, None] - angle
        mass = share * np.cos(between)
        off = share * np.sin(between)
        return np.append(omega, np.linalg.solve(mass, -off @ omega**2 - weight * np.cos(angle)))

    start = np.append(np.zeros(count) if angles is None else angles, np.zeros(count))
    found = solve_ivp(rates, (0, end), start, method="DOP853", rtol=tolerance, atol=tolerance)
    return found.y[:count, -1]


class SliderCrank:
    """Crank a with its inertia, rod l with its mass in the middle, slider on X; angle of the crank is the freedom."""

    a, rod = 0.05, 0.12
    crank_inertia, rod_mass, rod_inertia, slider_mass = 0.02, 0.21, 2.5e-4, 0.14

    def slider(self, angle):
        """Place of the slider, and two derivatives by the crank's angle; the same of the rod's angle."""
        s, c = self.a * np.sin(angle), self.a * np.cos(angle)
        turned = np.arcsin(-s / self.rod)
        cosine = self.rod * np.cos(turned)
        first = -c / cosine
        second = (s + self.rod * np.sin(turned) * first**2) / cosine
        place = c + cosine
        rate = -s - self.rod * np.sin(turned) * first
        bend = -c - cosine * first**2 - self.rod * np.sin(turned) * second
        return (place, rate, bend), (turned, first, second)

    def inertia(self, angle):
        """Inertia seen by the crank, and half of its derivative by the angle."""
        (_, rate, bend), (turned, first, second) = self.slider(angle)
        s, c, half = self.a * np.sin(angle), self.a * np.cos(angle), self.rod / 2
        x, y = -s - half * np.sin(turned) * first, c + half * np.cos(turned) * first
        x2 = -c - half * (np.cos(turned) * first**2 + np.sin(turned) * second)
        y2 = -s + half * (-np.sin(turned) * first**2 + np.cos(turned) * second)
        whole = self.crank_inertia + self.slider_mass * rate**2 + self.rod_mass * (x**2 + y**2)
        change = self.slider_mass * rate * bend + self.rod_mass * (x * x2 + y * y2)
        return whole + self.rod_inertia * first**2, change + self.rod_inertia * first * second

    def course(self, effort, start, times, tolerance=1e-12):
        """Angle and rate of the crank at times; `effort` gives torque of the crank by its angle and rate."""

        def rates(_, y):
            inertia, change = self.inertia(y[0])
            return [y[1], (effort(*y) - change * y[1] ** 2) / inertia]

        found = solve_ivp(rates, (0, times[-1]), start, "DOP853", times, rtol=tolerance, atol=tolerance)
        return found.y
