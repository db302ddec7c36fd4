"""Tracking of modes over the cycle, by their mass-weighted modal assurance criterion (MAC).

Two modes may come close and exchange their character. A mode is followed by its shape: it is the mode of the next
position whose MAC with it is largest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fenics_mech._arrays import Array, Index


@dataclass(frozen=True)
class Modes:
    """Natural frequencies and mode shapes over a cycle. Mode number i is the i-th lowest at the first angle.

    Parameters
    ----------
    theta
        Drive angles (rad), shape ``(angles,)``.
    omega
        Natural circular frequencies (rad/s), ``(angles, modes)``.
    shapes
        Mode shapes, orthonormal in M (E.7), with signs that do not jump, ``(angles, modes, coordinates)``.
    transfer
        ``Phi_{k+1}^T M_{k+1} Phi_k``, from each position to the next and from the last to the first,
        ``(angles, modes, modes)``.
    back
        ``Phi_k^T M_k Phi_{k+1}``, from each next position back, ``(angles, modes, modes)``.
    size
        Diagonal of ``Phi_k^T M_{k+1} Phi_k``, ``(angles, modes)``.
    """

    theta: Array
    omega: Array
    shapes: Array
    transfer: Array
    back: Array
    size: Array

    @property
    def frequency(self) -> Array:
        """Natural frequencies (Hz), ``(angles, modes)``."""
        return self.omega / (2 * np.pi)

    @property
    def elastic(self) -> Modes:
        """Those modes that are not of a rigid body."""
        return self.only(~(self.omega == 0).all(axis=0))

    def only(self, those: NDArray[np.bool_]) -> Modes:
        """Some of the modes, ``(modes,)``.

        Parameters
        ----------
        those
            Which of the modes, ``(modes,)``.
        """
        return Modes(
            self.theta,
            self.omega[:, those],
            self.shapes[:, those],
            self.transfer[:, those][:, :, those],
            self.back[:, those][:, :, those],
            self.size[:, those],
        )

    @property
    def assurance(self) -> Array:
        """MAC of each mode with itself at the next position, ``(angles, modes)``; the last row is the best match."""
        mac = self.transfer**2 / self.size[:, None, :]
        steps = np.einsum("kii->ki", mac).copy()
        steps[-1] = mac[-1].max(axis=0)
        return steps

    @property
    def closing(self) -> Array:
        """Signed permutation by which the modes come back after a cycle, ``(modes, modes)``."""
        target = _best_match(self.transfer[-1])
        closing = np.zeros_like(self.transfer[-1])
        for mode, place in enumerate(target):
            closing[place, mode] = 1.0 if self.transfer[-1][place, mode] >= 0 else -1.0
        return closing


def track(theta: Array, omega: Array, shapes: Array, transfer: Array, back: Array, size: Array) -> Modes:
    """Put modes that are sorted by frequency at each position into an order that follows their shapes.

    Parameters
    ----------
    theta, omega, shapes, transfer, back, size
        As of `Modes`, sorted by frequency at each angle.
    """
    count, modes = omega.shape
    order = np.broadcast_to(np.arange(modes), (count, modes)).copy()
    straight = np.einsum("kii->ki", transfer)
    sign = np.cumprod(np.vstack([np.ones(modes), np.where(straight[:-1] < 0, -1.0, 1.0)]), axis=0)
    crossing = (straight[:-1] ** 2).min(axis=1) <= 0.5  # above it, no other mode can match better
    for k in range(1 + int(np.argmax(crossing)), count) if crossing.any() else ():
        step = transfer[k - 1][:, order[k - 1]] * sign[k - 1]
        order[k] = _best_match(step)
        sign[k] = np.where(step[order[k], np.arange(modes)] < 0, -1.0, 1.0)
    rows = np.arange(count)[:, None]
    ahead, turn = np.roll(order, -1, axis=0), np.roll(sign, -1, axis=0)
    signs = turn[:, :, None] * sign[:, None, :]
    return Modes(
        theta=theta,
        omega=omega[rows, order],
        shapes=shapes[rows, order] * sign[..., None],
        transfer=transfer[rows[..., None], ahead[:, :, None], order[:, None, :]] * signs,
        size=size[rows, order],
        back=back[rows[..., None], order[:, :, None], ahead[:, None, :]] * signs.transpose(0, 2, 1),
    )


def _best_match(transfer: Array) -> Index:
    """For each mode (column), the mode of the next position (row) that it becomes."""
    likeness = transfer.T**2
    best = likeness.argmax(axis=1)
    if len(set(best)) == len(best):  # no two modes become the same one
        return best
    from scipy.optimize import linear_sum_assignment  # noqa: PLC0415  (slow to import)

    return linear_sum_assignment(likeness, maximize=True)[1]
