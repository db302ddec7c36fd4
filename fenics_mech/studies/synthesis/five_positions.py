"""Pins of a body in five positions: all of its points that lie on circles (Burmester points), without a search.

A pin ``z`` of the body, in the axes of its first position, is at ``d_i + z w_i`` in position i. On a circle about a
pivot ``c`` its distance from that does not change, which is bilinear in pin and pivot::

    |d_i|^2/2 + Re(z w_i conj(d_i)) - Re(conj(c) d_i) - Re(conj(c) z (w_i - 1)) = 0,    i = 2, 3, 4, 5

These four equations have six common zeros. Two are the circular points at infinity, so that there are at most four
pins, each with its pivot. The equations times all terms of second degree in the pin have null vectors in which the six
zeros are found as eigenvectors of a matrix of order 6.

Sources: Burmester, Lehrbuch der Kinematik, 1888; Sandor and Erdman, Advanced Mechanism Design, volume 2, 1984, section
3.6; McCarthy and Soh, Geometric Design of Linkages, 2nd edition, 2011, chapter 5; Cox, Little and O'Shea, Using
Algebraic Geometry, 2nd edition, 2005, section 2.4 (zeros by eigenvectors).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import SceneError
from fenics_mech.studies.synthesis.planar_four_bar import Complex, middle_and_size

SECOND = list(combinations_with_replacement(range(3), 2))  # terms of second degree in 1, x and y
THIRD: dict[tuple[int, ...], int] = {term: k for k, term in enumerate(combinations_with_replacement(range(3), 3))}
PRODUCT = np.array([[THIRD[tuple(sorted((*term, k)))] for k in range(3)] for term in SECOND])  # of the former with each
FORMS = np.array([[0.7, 0.3, -0.6], [0.2, -0.9, 0.5]])  # linear in 1, x, y, whose quotient tells the zeros apart
SAME = 1e-12  # singular value over the largest, from which the equations do not fix the zeros
FAR = 1e-4  # size of the positions over a distance, below which that is infinite
REAL = 1e-7  # imaginary part over the whole, below which a zero is real
ROUNDS = 4  # of Newton's method, which leave rounding
MISS = 1e-8  # of the size: largest change of a distance that counts as none


@dataclass(frozen=True)
class Dyad:
    """A pin of a body that moves on a circle."""

    pin: complex  # its place on the body (m), as x + i y
    pivot: complex  # centre of the circle (m)


def dyads_of_five(at: Complex, turns: Complex, place: str = "positions") -> list[Dyad]:
    """Find the pins of a body that lie on circles in five positions: none, two or four."""
    middle, size = middle_and_size(at, place)
    places = (at - middle) / size
    equations = _equations(places, turns)
    found = []
    for zero in _zeros(equations, place):
        pin, pivot = complex(zero[0], zero[1]), complex(zero[2], zero[3])
        on_body = (pin - places[0]) / turns[0]
        away = np.abs(places + on_body * turns - pivot)
        if np.ptp(away) < MISS * max(1.0, abs(pin), abs(pivot)):
            found.append(Dyad(complex(size * on_body), complex(middle + size * pivot)))
    return found


def _equations(at: Complex, turns: Complex) -> Array:
    """Coefficients of the equations by 1, x, y of the pin and 1, u, v of the pivot, ``(4, 3, 3)``."""
    w = turns / turns[0]
    d = at - w * at[0]
    one, turned, d, w = (w * d.conj())[1:], w[1:] - 1, d[1:], w[1:]
    rows = [
        [np.abs(d) ** 2 / 2, -d.real, -d.imag],
        [one.real, -turned.real, -turned.imag],
        [-one.imag, turned.imag, -turned.real],
    ]
    return np.moveaxis(np.array(rows), 2, 0)


def _zeros(equations: Array, place: str) -> list[Array]:
    """Real common zeros (x, y, u, v) that are not at infinity."""
    whole = np.zeros((len(SECOND), 4, len(THIRD), 3))
    for k in range(3):
        for term, column in enumerate(PRODUCT[:, k]):
            whole[term, :, column] += equations[:, k]
    _, sizes, rows = np.linalg.svd(whole.reshape(24, 30))
    if sizes[-1] < SAME * sizes[0]:
        message = "the five points do not fix the pins: two of them are the same, or the turns are in proportion"
        raise SceneError(message, place=place, hint="Move one of the five a little, or give three")
    null = rows[24:].T.reshape(len(THIRD), 3, 6)
    by_factor = np.stack([null[PRODUCT[:, k]].reshape(-1, 6) for k in range(3)])  # 1, x or y times the second degree
    below, above = np.einsum("fk,kab->fab", FORMS, by_factor)
    _, vectors = np.linalg.eig(np.linalg.lstsq(below, above, rcond=None)[0])
    found = []
    for product in np.moveaxis(by_factor @ vectors, 2, 0):
        pin = np.linalg.svd(product)[0][:, 0]
        pivot = np.linalg.svd(product.reshape(-1, 3))[2][0]
        if min(abs(one[0]) / np.abs(one).max() for one in (pin, pivot)) > FAR:
            zero = _improved(equations, np.concatenate([pin[1:] / pin[0], pivot[1:] / pivot[0]]))
            if np.abs(zero.imag).max() < REAL * np.abs(zero).max():
                found.append(zero.real)
    return found


def _improved(equations: Array, zero: Complex) -> Complex:
    """Give a zero to rounding by Newton's method, ``(4,)``."""
    for _ in range(ROUNDS):
        pin, pivot = np.append(1, zero[:2]), np.append(1, zero[2:])
        by_pin, by_pivot = equations @ pivot, np.einsum("i,kij->kj", pin, equations)
        jacobian = np.concatenate([by_pin[:, 1:], by_pivot[:, 1:]], axis=1)
        zero = zero - np.linalg.lstsq(jacobian, by_pin @ pin, rcond=None)[0]
    return zero
