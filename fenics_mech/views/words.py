"""Numbers in words of people: three digits, a true minus, no exponent where a person would not write one."""

from __future__ import annotations

import math

from fenics_mech._constants import TURN
from fenics_mech.errors import percent, percent_of_error

DEGREE, MINUS = "\N{DEGREE SIGN}", "\N{MINUS SIGN}"
AT_MOST = "\N{LESS-THAN OR EQUAL TO} "
LEAST, MOST = 1e-4, 1e6  # between them no exponent is written
UNSEEN = 5e-4  # share below which a percentage has no digits


def short(value: float, digits: int = 3) -> str:
    """Round a number to significant digits."""
    if not math.isfinite(value):
        return "\N{EN DASH}"
    if value == 0:
        return "0"
    value = float(f"{value:.{digits - 1}e}")  # so that 9.9999 counts as 10
    if not LEAST <= abs(value) < MOST:
        return f"{value:.{digits - 1}e}".replace("-", MINUS)
    places = max(digits - 1 - math.floor(math.log10(abs(value))), 0)
    return f"{value:.{places}f}".replace("-", MINUS)


def in_degrees(angle: float) -> str:
    """Write a drive angle within the turn, in degrees to one decimal."""
    # angle: the angle (rad)
    degrees = round(math.degrees(round(angle, 12) % TURN), 1)
    return f"{0 if degrees == 360 else degrees:g}{DEGREE}"


def share(value: float) -> str:
    """Write a share in percent, as "less than 0.1 %" where it is small."""
    return percent(value) if value >= UNSEEN or not math.isfinite(value) else "less than 0.1 %"


def error_share(value: float) -> str:
    """Write an error in percent as `share` does; from 100 % on no more than that is known of it."""
    return share(value) if value < UNSEEN else percent_of_error(value)


def sentence(text: str) -> str:
    """Begin a text with a capital letter, and leave the rest as it is."""
    return text[:1].upper() + text[1:]
