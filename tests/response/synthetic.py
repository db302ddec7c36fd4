"""Equations of motion with known answers, for the solvers of the periodic response."""

from types import SimpleNamespace

import numpy as np
from scipy.sparse import csr_matrix

from fenics_mech.effects import NOTHING
from fenics_mech.eigenmodes import Modes
from fenics_mech.mechanism.matrices import Matrices
from fenics_mech.response.stability.turning import LinkAxes
from fenics_mech.scene import Scene

PERIOD = 2 * np.pi / 3


def places(points, count, period=PERIOD):
    """Times at places in every one of `count` steps."""
    return (period / count * (np.arange(count)[:, None] + points)).ravel()


def plain(matrices):
    """What the solvers take, from matrices alone."""
    return SimpleNamespace(linear=matrices, system=SimpleNamespace(terms=NOTHING))


def oscillators(time, omega, damping, load=None):
    """Uncoupled oscillators of unit mass; omega and damping are ``(oscillators,)``."""
    eye = np.eye(len(omega))
    matrices = [np.broadcast_to(m, (len(time), *m.shape)).copy() for m in (eye, damping * eye, omega**2 * eye)]
    return Matrices.of_full(*matrices, np.zeros((len(time), len(omega))) if load is None else load)


def modes_of(omega):
    """Modes of oscillators."""
    one = np.ones((1, 1, 1))
    return Modes(np.zeros(1), np.array([omega], float), np.eye(len(omega))[None], one, one, one[0])


def axes_of(matrices, count):
    """Axes of one link that does not turn, in as many steps."""
    size = matrices.mass.size
    each, ones = np.arange(size), np.ones((count, size))
    return LinkAxes(each, each, ones, 0 * ones, csr_matrix(matrices.mass.dense(0)), 0 * each, ("link",))


class Manufactured:
    """Two coordinates with periodic M, C, K, and the load that makes q = exp(sin), cos exp(cos) their motion."""

    rate = 2 * np.pi / PERIOD

    def motion(self, time):
        """q, q', q'', each ``(times, 2)``."""
        s, c, w = np.sin(self.rate * time), np.cos(self.rate * time), self.rate
        first = np.exp(s) * np.stack([np.ones_like(s), w * c, w**2 * (c**2 - s)])
        e = np.exp(c)
        second = np.stack([c * e, -w * s * e * (1 + c), w**2 * e * (s**2 * (2 + c) - c * (1 + c))])
        return np.stack([first, second], axis=-1)

    def matrices(self, time):
        """M, C, K and the load at the times."""
        c, s = np.cos(self.rate * time), np.sin(self.rate * time)
        blocks = [[[2 + c, 0.5 * s], [0.5 * s, 1.5 - 0.5 * c]], [[1 + 0.5 * s, c], [-c, 0.8 + 0 * c]]]
        blocks.append([[30 + 6 * c, -5 + s], [-5 - s, 25 + 4 * s]])
        parts = [np.moveaxis(np.array(np.broadcast_arrays(*b[0] + b[1])), -1, 0).reshape(-1, 2, 2) for b in blocks]
        load = sum(np.einsum("tij,tj->ti", part, q) for part, q in zip(parts, self.motion(time)[::-1]))
        return Matrices.of_full(*parts, load)


class Duffing:
    """``q'' + c q' + k q + b q^3 = f(t)`` with the load that makes ``q = a cos(rate t)`` its motion."""

    rate, amplitude, damping, stiffness, cubic = 2 * np.pi / PERIOD, 0.8, 0.3, 4.0, 2.0

    def __init__(self, time):
        q, rate = self.motion(time)
        load = -(self.rate**2) * q + self.damping * rate + self.stiffness * q + self.cubic * q**3
        ones = np.ones((len(time), 1, 1))
        self.linear = Matrices.of_full(ones, self.damping * ones, self.stiffness * ones, load)
        self.links_stiffness = self.linear.stiffness
        self.system = SimpleNamespace(terms=SimpleNamespace(law=self), motion=SimpleNamespace(theta=time))
        self.tension = np.zeros((len(time), 1))

    def motion(self, time):
        """Give q and q'."""
        angle = self.rate * time[:, None]
        return self.amplitude * np.cos(angle), -self.rate * self.amplitude * np.sin(angle)

    def linearised(self, q, rate, tension, share=1.0, second=None):
        """The tangent at q, under a share of the load."""
        stiffness = self.linear.stiffness.full + 3 * self.cubic * q[..., None] ** 2
        return Matrices.of_full(
            self.linear.mass.full, self.linear.damping.full, stiffness, share * self.linear.load + 2 * self.cubic * q**3
        )

    def predicted_tension(self, tangents, q, rate):
        """There is none."""
        return self.tension

    def residual_near(self, tangents, state, tension, share):
        """What is left of the equation under a share of the load, and the tangents as they are."""
        return self.residual(*state) + (1 - share) * self.linear.load, tangents

    def residual(self, q, rate, second):
        """What is left of the equation."""
        return second + self.damping * rate + self.stiffness * q + self.cubic * q**3 - self.linear.load


def arm(speed, **rest):
    """A steel arm on a turning shaft, bent by its weight, which turns against it."""
    strip = {"shape": "rectangle", "width": "20 mm", "height": "2 mm"}
    member = {"ends": ["O", "A"], "section": "strip", "material": "steel"}
    return Scene.read(
        {
            "materials": {"steel": {"modulus": "206 GPa", "density": "7850 kg/m^3"}},
            "sections": {"strip": strip},
            "ground": {"points": {"O": (0, 0)}},
            "links": {"arm": {"points": {"O": (0, 0), "A": (0.5, 0)}, "members": {"beam": member}}},
            "joints": {"O": {"connect": ["ground.O", "arm.O"]}},
            "drive": {"joint": "O", "speed": speed},
            "loads": {"tip": {"at": "arm.A", "force": (0.0, -1.0)}},
        }
        | rest
    )
