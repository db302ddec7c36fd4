"""MECQBAR: kinematics, joint forces and mid-span strains of a rigid four-bar, Kaminski (1989), chapter 6.

Numbers in parentheses are the dissertation's equations. Where its print is wrong the comment says "erratum"; every
erratum was settled by the numbers of Appendix G, see `compare_appendix_g`.
"""

from __future__ import annotations

import csv
from dataclasses import dataclass
from importlib import resources

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .parameters import FourBarParameters

Array = NDArray[np.float64]
Columns = dict[str, Array]

COMPARED_ROWS = 25
"""Rows of Appendix G that are compared: one turn of the crank, both ends printed."""

NOISE = 1e-12
"""Below this a number printed with an exponent is the rounding noise of an exact zero (9.6E-17, 2.3E-13)."""


def positions(theta1: ArrayLike, parameters: FourBarParameters) -> Columns:
    """Link angles in the assembly branch with B to the left of the vector from A to C.

    Parameters
    ----------
    theta1
        Crank angle from OC (rad), any shape.
    parameters
        The four-bar.

    Returns
    -------
    dict
        ``m_m`` (m), ``theta_m_rad``, ``theta2_rad``, ``theta3_rad`` (rad), each of the shape of `theta1`.

    Raises
    ------
    ValueError
        If the coupler and the follower do not reach each other at some angle.
    """
    theta1 = np.asarray(theta1, dtype=float)
    a, b, c, ground = parameters.a, parameters.b, parameters.c, parameters.L
    m = np.sqrt(a**2 + ground**2 - 2 * a * ground * np.cos(theta1))  # (6.19)
    theta_m = np.arctan2(-a * np.sin(theta1), ground - a * np.cos(theta1))  # (6.17), (6.18)
    cos3 = (b**2 - m**2 - c**2) / (2 * m * c)  # (6.25)
    cos2 = (b**2 + m**2 - c**2) / (2 * m * b)  # (6.26)
    apart = (np.abs(cos3) > 1) | (np.abs(cos2) > 1)
    if np.any(apart):
        angle = float(np.degrees(theta1[apart].flat[0]))
        raise ValueError(f"coupler {b} m and follower {c} m cannot be joined at crank angle {angle:.6g} deg")
    return {
        "m_m": m,
        "theta_m_rad": theta_m,
        "theta2_rad": theta_m + np.arccos(cos2),
        "theta3_rad": theta_m + np.arccos(cos3),
    }


def rates(theta1: ArrayLike, theta2: Array, theta3: Array, parameters: FourBarParameters) -> Columns:
    """Angular speeds and accelerations of coupler and follower at constant crank speed.

    Parameters
    ----------
    theta1, theta2, theta3
        Angles of crank, coupler and follower (rad), all of one shape.
    parameters
        The four-bar.

    Returns
    -------
    dict
        ``omega2_rad_s``, ``omega3_rad_s`` (rad/s), ``alpha2_rad_s2``, ``alpha3_rad_s2`` (rad/s^2).
    """
    theta1 = np.asarray(theta1, dtype=float)
    a, b, c, w1 = parameters.a, parameters.b, parameters.c, parameters.omega1
    sin32, cos32 = np.sin(theta3 - theta2), np.cos(theta3 - theta2)
    w2 = -a * w1 * np.sin(theta3 - theta1) / (b * sin32)  # (6.8)
    w3 = -a * w1 * np.sin(theta2 - theta1) / (c * sin32)  # (6.9)
    alpha2 = (a * w1**2 * np.cos(theta3 - theta1) + b * w2**2 * cos32 - c * w3**2) / (b * sin32)  # (6.13)
    alpha3 = (a * w1**2 * np.cos(theta2 - theta1) - c * w3**2 * cos32 + b * w2**2) / (c * sin32)  # (6.14)
    return {"omega2_rad_s": w2, "omega3_rad_s": w3, "alpha2_rad_s2": alpha2, "alpha3_rad_s2": alpha3}


def _accelerations(motion: Columns, parameters: FourBarParameters) -> Columns:
    """Accelerations of A, B and the coupler's centre G2 along the fixed axes (m/s^2)."""
    theta1, theta2, theta3 = motion["theta1_rad"], motion["theta2_rad"], motion["theta3_rad"]
    a, b, c, w1 = parameters.a, parameters.b, parameters.c, parameters.omega1
    w2, w3, alpha2, alpha3 = (motion[k] for k in ("omega2_rad_s", "omega3_rad_s", "alpha2_rad_s2", "alpha3_rad_s2"))
    a_ax, a_ay = -a * w1**2 * np.cos(theta1), -a * w1**2 * np.sin(theta1)  # (6.28)
    return {
        "aBx_m_s2": -c * w3**2 * np.cos(theta3) - c * alpha3 * np.sin(theta3),  # (6.3)
        "aBy_m_s2": -c * w3**2 * np.sin(theta3) + c * alpha3 * np.cos(theta3),  # (6.3)
        "aAx_m_s2": a_ax,
        "aAy_m_s2": a_ay,
        "aG2x_m_s2": a_ax - b / 2 * (alpha2 * np.sin(theta2) + w2**2 * np.cos(theta2)),  # (6.30)
        "aG2y_m_s2": a_ay + b / 2 * (alpha2 * np.cos(theta2) - w2**2 * np.sin(theta2)),  # (6.30)
    }


def _joint_forces(motion: Columns, parameters: FourBarParameters) -> Columns:
    """Give the forces on the coupler at A and B along the fixed axes (N), and the bracket they share (m/s^2)."""
    theta2, theta3 = motion["theta2_rad"], motion["theta3_rad"]
    _, m2, m3 = parameters.masses
    a_gx, a_gy = motion["aG2x_m_s2"], motion["aG2y_m_s2"]
    sin32 = np.sin(theta3 - theta2)
    aux = parameters.b * motion["alpha2_rad_s2"] / 12 - a_gx * np.sin(theta2) / 2 + a_gy * np.cos(theta2) / 2
    # Erratum: the factor of (6.36) and (6.37) is m_B + m_3/3, printed m_3 + m_3/3.
    follower = (parameters.mass_B + m3 / 3) * parameters.c * motion["alpha3_rad_s2"]
    x_b = (m2 * np.cos(theta3) * aux + follower * np.cos(theta2)) / sin32  # (6.36)
    y_b = (m2 * np.sin(theta3) * aux + follower * np.sin(theta2)) / sin32  # (6.37)
    return {
        "aux_m_s2": aux,
        "XB_N": x_b,
        "YB_N": y_b,
        "XA_N": m2 * a_gx - x_b,  # (6.31)
        "YA_N": m2 * a_gy - y_b,  # (6.31)
    }


def _crank_strain(motion: Columns, parameters: FourBarParameters) -> Columns:
    """Force of the coupler on the crank along its axes (N) and mid-span strain of the crank."""
    theta1, x_a, y_a = motion["theta1_rad"], motion["XA_N"], motion["YA_N"]
    (m1, _, _), a, young = parameters.masses, parameters.a, parameters.E
    r_a = x_a * np.sin(theta1) - y_a * np.cos(theta1)  # (6.36), second of that number
    s_a = x_a * np.cos(theta1) + y_a * np.sin(theta1)  # (6.37), second of that number
    inertia_force = (parameters.mass_A + 3 * m1 / 8) * a * parameters.omega1**2
    axial = (inertia_force - s_a) / (parameters.area[0] * young)  # (6.42)
    bending = -r_a * parameters.fibre[0] * a / (2 * parameters.inertia[0] * young)  # (6.43)
    return {"RA_N": r_a, "SA_N": s_a, "eps1_axial": axial, "eps1_bending": bending, "eps1": axial + bending}


def _coupler_strain(motion: Columns, parameters: FourBarParameters) -> Columns:
    """Force at B on the coupler along its axes (N) and mid-span strain of the coupler."""
    theta1, theta2, x_b, y_b = motion["theta1_rad"], motion["theta2_rad"], motion["XB_N"], motion["YB_N"]
    w2, alpha2 = motion["omega2_rad_s"], motion["alpha2_rad_s2"]
    (_, m2, _), b, young = parameters.masses, parameters.b, parameters.E
    a_a = parameters.a * parameters.omega1**2
    s_b = x_b * np.cos(theta2) + y_b * np.sin(theta2)  # (6.45)
    r_b = -x_b * np.sin(theta2) + y_b * np.cos(theta2)  # (6.46)
    # The components of the acceleration of A along the coupler are -a_a cos and +a_a sin of (theta2 - theta1):
    # the second is an erratum of (6.47) and (6.48), whose first sine product is printed with the wrong sign.
    tension = s_b + 3 * m2 * w2**2 * b / 8 + m2 * a_a * np.cos(theta2 - theta1) / 2
    moment = -r_b * b + m2 * b * a_a * np.sin(theta2 - theta1) / 4 + 5 * m2 * b**2 * alpha2 / 24
    axial = tension / (parameters.area[1] * young)  # (6.50)
    bending = moment * parameters.fibre[1] / (2 * parameters.inertia[1] * young)  # (6.51)
    return {"SB_N": s_b, "RB_N": r_b, "eps2_axial": axial, "eps2_bending": bending, "eps2": axial + bending}


def _follower_strain(motion: Columns, parameters: FourBarParameters) -> Columns:
    """Force of the coupler on the follower along its axes (N) and mid-span strain of the follower."""
    theta3, x_b, y_b = motion["theta3_rad"], motion["XB_N"], motion["YB_N"]
    w3, alpha3 = motion["omega3_rad_s"], motion["alpha3_rad_s2"]
    (_, _, m3), c, young = parameters.masses, parameters.c, parameters.E
    r_b = x_b * np.sin(theta3) - y_b * np.cos(theta3)  # (6.52)
    s_b = x_b * np.cos(theta3) + y_b * np.sin(theta3)  # (6.53)
    # Errata: the lumped mass of (6.56) and (6.57) is m_B, printed m_3; (6.56) has no further division by 8; the
    # bending strain has the opposite sign. It is that of the fibre to the right of the axis from C to B.
    tension = -s_b + (parameters.mass_B + 3 * m3 / 8) * w3**2 * c
    moment = r_b * c - (parameters.mass_B + 5 * m3 / 24) * c**2 * alpha3
    axial = tension / (parameters.area[2] * young)  # (6.56)
    bending = moment * parameters.fibre[2] / (2 * parameters.inertia[2] * young)  # (6.57)
    return {"RBp_N": r_b, "SBp_N": s_b, "eps3_axial": axial, "eps3_bending": bending, "eps3": axial + bending}


def mecqbar(theta1: ArrayLike, parameters: FourBarParameters | None = None) -> Columns:
    """Everything Appendix G tabulates, at any crank angles.

    Parameters
    ----------
    theta1
        Crank angle from OC (rad), any shape.
    parameters
        The four-bar; the dissertation's when left out.

    Returns
    -------
    dict
        The columns of Appendix G in its order, each of the shape of `theta1`. The name ends in the unit; ``eps``
        columns are strains (no unit). ``eps1`` and ``eps2`` belong to the fibre to the left of the axes O-A and A-B,
        ``eps3`` to the fibre to the right of the axis C-B.
    """
    parameters = parameters or FourBarParameters()
    motion: Columns = {"theta1_rad": np.asarray(theta1, dtype=float)}
    motion |= positions(theta1, parameters)
    motion |= rates(theta1, motion["theta2_rad"], motion["theta3_rad"], parameters)
    for step in (_accelerations, _joint_forces, _crank_strain, _coupler_strain, _follower_strain):
        motion |= step(motion, parameters)
    return motion


@dataclass(frozen=True)
class Disagreement:
    """One printed number that the program does not give.

    Parameters
    ----------
    row, column
        Row (from 0) and column name of Appendix G.
    printed
        The text of the cell.
    computed
        The number of `mecqbar`, in the column's unit.
    """

    row: int
    column: str
    printed: str
    computed: float


@dataclass(frozen=True)
class AppendixComparison:
    """What came of comparing `mecqbar` with Appendix G.

    Parameters
    ----------
    compared
        Number of printed numbers compared.
    agreeing
        Number of them that agree within one unit of the last printed digit.
    same_digits
        Number of them whose digits, once the computed number is cut to the printed ones, are the same.
    disagreeing
        The others, in the order of the print.
    """

    compared: int
    agreeing: int
    same_digits: int
    disagreeing: tuple[Disagreement, ...]


def _last_digit(printed: str) -> float:
    """Value of one unit of the last digit of a printed number; zero for a bare 0, which is printed exactly."""
    mantissa, _, exponent = printed.upper().partition("E")
    if float(printed) == 0 and "." not in mantissa:
        return 0.0
    return float(f"1e{int(exponent or 0) - len(mantissa.partition('.')[2])}")


def compare_appendix_g(parameters: FourBarParameters | None = None) -> AppendixComparison:
    """Compare `mecqbar` with the first 25 printed rows of Appendix G, crank angles k pi/12, k = 0..24.

    The 25 rows hold 35 columns. Not counted are the crank angle itself, which is the input (25 cells), and the six
    cells that are printed with an exponent and stand for exact zeros: ``theta_m`` at 180 and 360 degrees, the X
    component of the acceleration of A at 90 and 270 and its Y component at 180 and 360 (9.6E-17 to 2.3E-13, the
    rounding noise of the spreadsheet). That leaves 25 * 34 - 6 = 844 numbers, and each is compared.

    A number agrees when it is within one unit of the last printed digit, because the print is cut to its width and
    not rounded. A bare ``0`` has no last digit and agrees with an exact zero only.

    Parameters
    ----------
    parameters
        The four-bar; the dissertation's when left out.

    Returns
    -------
    AppendixComparison
        Counts and the list of the cells that disagree.
    """
    computed = mecqbar(np.arange(COMPARED_ROWS) * np.pi / 12, parameters)
    text = resources.files(__package__).joinpath("mecqbar_appendix_g.csv").read_text(encoding="utf-8")
    compared = same_digits = 0
    disagreeing: list[Disagreement] = []
    for row, cells in enumerate(list(csv.DictReader(text.splitlines()))[:COMPARED_ROWS]):
        for column, printed in cells.items():
            if column == "theta1_rad" or ("E" in printed and abs(float(printed)) < NOISE):
                continue
            compared += 1
            value, number, unit = float(computed[column][row]), float(printed), _last_digit(printed)
            if abs(value - number) > unit * (1 + 1e-9):  # the last factor is for the decimal-to-binary conversion
                disagreeing.append(Disagreement(row, column, printed, value))
            digits = value if unit == 0 else unit * np.trunc(value / unit * (1 + 1e-12))
            same_digits += bool(abs(digits - number) <= 1e-6 * unit)
    return AppendixComparison(compared, compared - len(disagreeing), same_digits, tuple(disagreeing))
