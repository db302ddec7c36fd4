"""Machines that several hard cases share, and their answers by hand-coded elements."""

import numpy as np
from scipy.linalg import eigh

from fenics_mech.scene import Scene


def arm(speed, **rest):
    """A steel arm of 0.5 m on a turning shaft; a force at its tip turns against it, so that harmonic 1 bends it."""
    member = {"ends": ["O", "A"], "section": "strip", "material": "steel"}
    return Scene.read(
        {
            "materials": {"steel": {"modulus": "206 GPa", "density": "7850 kg/m^3"}},
            "sections": {"strip": {"shape": "rectangle", "width": "20 mm", "height": "2 mm"}},
            "ground": {"points": {"O": (0, 0)}},
            "links": {"arm": {"points": {"O": (0, 0), "A": (0.5, 0)}, "members": {"beam": member}}},
            "joints": {"O": {"connect": ["ground.O", "arm.O"]}},
            "drive": {"joint": "O", "speed": speed},
            "loads": {"tip": {"at": "arm.A", "force": (0.0, -1.0)}},
        }
        | rest
    )


def _elements(scene):
    """Hand-coded matrices of the arm, clamped at its shaft: K, M, the Coriolis matrix G, M times x along and across.

    Elements are bars along, and cubic across (Przemieniecki, ch. 5 and 11). Degrees of freedom are u, w and phi of each
    node but the first.
    """
    (member,), (section,) = scene.links["arm"].members.values(), scene.sections.values()
    material = scene.materials[member.material]
    EA, EI, line = material.modulus * section.area, material.modulus * section.inertia, material.density * section.area
    count = scene.mesh.elements
    h, n = 0.5 / count, 3 * (count + 1)
    K, M, G, pull, push = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n)), np.zeros(n), np.zeros(n)
    gauss, weights = np.polynomial.legendre.leggauss(4)
    for element in range(count):
        dofs = slice(3 * element, 3 * element + 6)
        for s, weight in zip((gauss + 1) / 2, weights * h / 2):
            u = np.array([1 - s, 0, 0, s, 0, 0])
            w = np.array(
                [0, 1 - 3 * s**2 + 2 * s**3, h * (s - 2 * s**2 + s**3), 0, 3 * s**2 - 2 * s**3, h * (s**3 - s**2)]
            )
            bent = np.array([0, 12 * s - 6, h * (6 * s - 4), 0, 6 - 12 * s, h * (6 * s - 2)]) / h**2
            stretched = np.array([-1, 0, 0, 1, 0, 0]) / h
            K[dofs, dofs] += weight * (EA * np.outer(stretched, stretched) + EI * np.outer(bent, bent))
            M[dofs, dofs] += weight * line * (np.outer(u, u) + np.outer(w, w))
            G[dofs, dofs] += weight * line * (np.outer(w, u) - np.outer(u, w))
            pull[dofs] += weight * line * u * h * (element + s)
            push[dofs] += weight * line * w * h * (element + s)
    return K[3:, 3:], M[3:, 3:], G[3:, 3:], pull[3:], push[3:]


def natural(scene):
    """Natural frequencies of the arm held still (rad/s), and its modes, orthonormal in the mass."""
    K, M, *_ = _elements(scene)
    squares, shapes = eigh(K, M)
    return np.sqrt(squares), shapes


def critical(scene, harmonic=1, coupled=True):
    """Speeds at which a harmonic of the drive meets a mode (rad/s): with the coupling one of the turning arm."""
    K, M, G, *_ = _elements(scene)
    across = (harmonic**2 + 1) * M - 2j * harmonic * G if coupled else harmonic**2 * M
    return np.sqrt(eigh(K, across)[0])


def answer(scene, decay, coupled=True, drag=0.0):
    """Displacement of the arm's tip across it over the cycle, ``(positions,)``, harmonic by harmonic.

    Parameters
    ----------
    scene
        Its force has no harmonic above 1.
    decay
        Damping of each mode over its mass (1/s), as a function of its frequency.
    coupled
        Whether the frame's turning acts on the displacement.
    drag
        Of the surroundings, over the mass (1/s), on the whole velocity.
    """
    K, M, G, pull, push = _elements(scene)
    omega, shapes = natural(scene)
    C = M @ shapes @ np.diag(decay(omega)) @ shapes.T @ M
    speed, (load,) = scene.cycle_rate, scene.loads.values()
    count = scene.analysis.sub_intervals
    theta, found = 2 * np.pi * np.arange(count) / count, np.zeros(count)
    x, y = load.force
    for harmonic, along, over in ((0, 0.0, 0.0), (1, x - 1j * y, y + 1j * x)):  # of exp(i theta)
        force = np.zeros(len(K), dtype=complex)
        force[-3:-1] = along, over
        force += (harmonic == 0) * (speed**2 * pull - drag * speed * push)
        s = harmonic * speed
        matrix = K - s**2 * M + 1j * s * (C + drag * M) + drag * speed * G
        matrix += coupled * (2j * s * speed * G - speed**2 * M)
        found += np.real(np.linalg.solve(matrix, force)[-2] * np.exp(1j * harmonic * theta))
    return found
