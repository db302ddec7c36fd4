"""The slider-crank with a loose slider of Flores, Leine and Glocker (2010), with impacts that take no time.

An independent program: two bars and a slider on their end, free between the impacts of the slider on its walls, with
Newton's restitution. The slider does not turn without friction, as both of its corners meet a wall together.
Data: their table 1.
"""

import numpy as np
from scipy.integrate import solve_ivp

CRANK, ROD, HALF, PLAY = 0.153, 0.306, 0.05, 1e-3  # m
MASSES, INERTIAS = (0.038, 0.038, 0.076), (7.4e-5, 5.9e-4, 2.7e-6)  # kg, kg m^2
SPEED, RESTITUTION, G = 150.0, 0.4, 9.81


def mass(q):
    """Mass matrix of the angles of crank and rod (kg m^2)."""
    (m1, m2, m3), (j1, j2, _) = MASSES, INERTIAS
    coupled = (m2 / 2 + m3) * CRANK * ROD * np.cos(q[0] - q[1])
    of_crank, of_rod = j1 + (m1 / 4 + m2 + m3) * CRANK**2, j2 + (m2 / 4 + m3) * ROD**2
    return np.array([[of_crank, coupled], [coupled, of_rod]])


def rates(_, y):
    """Rates and accelerations of the angles between impacts."""
    (m1, m2, m3), (q, omega) = MASSES, (y[:2], y[2:])
    coupled = (m2 / 2 + m3) * CRANK * ROD * np.sin(q[0] - q[1])
    of_crank = -coupled * omega[1] ** 2 - (m1 / 2 + m2 + m3) * G * CRANK * np.cos(q[0])
    of_rod = coupled * omega[0] ** 2 - (m2 / 2 + m3) * G * ROD * np.cos(q[1])
    return np.append(omega, np.linalg.solve(mass(q), [of_crank, of_rod]))


def gap(y, wall):
    """Distance of the slider from the upper (1) or lower (-1) wall (m)."""
    return PLAY - wall * (CRANK * np.sin(y[0]) + ROD * np.sin(y[1]))


def course(impacts):
    """Times of the first impacts (s), and angles and their rates after each, from the start on."""
    events = [lambda _, y, wall=wall: gap(y, wall) for wall in (1, -1)]
    for event in events:
        event.terminal, event.direction = True, -1
    found = [(0.0, np.array([0.0, 0.0, SPEED, -SPEED * CRANK / ROD]))]
    while len(found) <= impacts:
        flight = solve_ivp(rates, (found[-1][0], 1.0), found[-1][1], "DOP853", events=events, rtol=1e-11, atol=1e-13)
        y = flight.y[:, -1].copy()
        by = np.array([CRANK * np.cos(y[0]), ROD * np.cos(y[1])])
        given = np.linalg.solve(mass(y[:2]), by)
        y[2:] -= (1 + RESTITUTION) * (by @ y[2:]) / (by @ given) * given
        found.append((flight.t[-1], y))
    return found


def flown(state, time):
    """Angles and their rates at a time of the flight after a state."""
    return solve_ivp(rates, (state[0], time), state[1], "DOP853", rtol=1e-11, atol=1e-13).y[:, -1]
