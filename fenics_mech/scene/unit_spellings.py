"""Spellings of units beside those of SI: what can mean one thing is read, what is likely meant is suggested."""

from __future__ import annotations

import re
from collections.abc import Callable
from contextlib import suppress

LENGTHS_AND_TIMES = r"(?:mm|cm|dm|km|um|\u00b5m|m|in|ft|yd|ms|us|sec|s|min|h)"
READ = (  # each has one meaning
    (re.compile(rf"(?<![A-Za-z])({LENGTHS_AND_TIMES})([234])(?![\w.])"), r"\1^\2"),  # mm2
    (re.compile(r"(?<=[A-Za-z])-(?=[A-Za-z])"), " "),  # N-m
    (re.compile(r"(?<=[A-Za-z])(?<![\d.][eE])-([1-4])(?![\w.])"), r"^-\1"),  # m-3, and not 1e-3
    (re.compile(r"\b(?:RPM|(?:revs?|r|U|tr)\s*/\s*min)\b"), "rpm"),
    (re.compile(r"\b([kMm]|da)?N(mm|cm|m)\b"), r"\1N \2"),  # Nm
    (re.compile(r"\bN(?=s\b)"), "N "),  # Ns
    (re.compile(r"\bkp\b"), "kgf"),  # kilopond
)
NAMES = [
    "m", "mm", "cm", "dm", "km", "um", "in", "ft", "kg", "mg", "t", "lb", "N", "kN", "MN", "daN", "Pa", "kPa", "MPa",
    "GPa", "bar", "psi", "ksi", "lbf", "kgf", "Hz", "kHz", "rad", "mrad", "deg", "rpm", "s", "ms", "min", "h", "J",
    "W", "kW",
]  # fmt: skip
MEANT = {name.lower(): name for name in NAMES} | {  # by what is written, in small letters
    "kgs": "kg", "g": "g", "gm": "g", "gms": "g", "gr": "g", "grs": "g", "newton": "N", "newtons": "N", "pct": "%",
    "cps": "Hz", "rads": "rad", "nm": "N m", "knm": "kN m", "nmm": "N mm", "kgm": "kg m", "kgcm": "kg cm",
    "kgmm": "kg mm", "nms": "N m s", "ns": "N s",
    "cbm": "m^3", "cum": "m^3", "ccm": "cm^3", "sqm": "m^2", "sqcm": "cm^2", "sqmm": "mm^2",
    "rev": "turn", "revs": "turn", "u": "turn", "tr": "turn", "rps": "turn/s", "upm": "rpm",
}  # fmt: skip
SIGNS = {'"': " in", "\N{DOUBLE PRIME}": " in", "'": " ft", "\N{PRIME}": " ft"}
POUND = re.compile(r"\blbs?\b")  # of force, where it is read as a mass
WORD = re.compile(r"(?<![A-Za-z])[A-Za-z]+")


def spelled(text: str) -> str:
    """Write the units of a quantity as they are read: mm2 as mm^2, Nm as N m, RPM as rpm."""
    for pattern, to in READ:
        text = pattern.sub(to, text)
    return text


def meant(text: str, reads: Callable[[str], float]) -> str:
    """Give the quantity that is likely meant by one that is not read; empty where none is."""
    changed = text
    for sign, name in SIGNS.items():
        changed = changed.replace(sign, name)
    usual = spelled(WORD.sub(lambda word: MEANT.get(word[0].lower(), word[0]), changed))
    for found in (usual, POUND.sub("lbf", usual)):
        with suppress(ValueError):
            if found != text:
                reads(found)
                return found
    return ""
