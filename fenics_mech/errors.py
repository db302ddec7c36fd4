"""The errors of fenics_mech: each says what was found, where, what is expected and what to do."""

from __future__ import annotations

import reprlib
from collections.abc import Mapping
from types import MappingProxyType
from typing import Self

ANSWERED = True  # of an error: there is an answer nevertheless, whose error is estimated
LONGEST_MESSAGE, LONGEST_VALUE = 1000, 160  # characters of a message, and of a value that is shown in one


class MechanismError(Exception):
    """Base of every error that a user of the program can meet; its text is one line without control characters.

    Parameters
    ----------
    message
        What was found, where, what is expected, and what to do.

    Attributes
    ----------
    finer
        What makes an analysis fine enough that is too coarse: "elements" by how many times as many, the others by
        their keys in `analysis`. Empty where nothing of that kind helps.
    answered
        Whether there is an answer nevertheless, whose error is estimated.

    Examples
    --------
    >>> try:
    ...     fm.load("nowhere.toml")
    ... except fm.MechanismError as error:
    ...     print(error)
    nowhere.toml: cannot read the scene file: No such file or directory
    """

    finer: Mapping[str, float] = MappingProxyType({})
    answered: bool = False

    def finer_by(self, answered: bool = False, /, **numbers: float) -> Self:
        """Give the error, which says what makes the analysis fine enough.

        Parameters
        ----------
        answered
            Whether there is an answer nevertheless, whose error is estimated.
        **numbers
            As `finer`.
        """
        self.finer, self.answered = numbers, answered
        return self

    def __init__(self, message: str) -> None:
        line = printable(message)
        super().__init__(line if len(line) <= LONGEST_MESSAGE else f"{line[:LONGEST_MESSAGE]} ...")


def printable(text: str) -> str:
    """Show control characters of a text as Python writes them."""
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)


def shortened(value: object) -> str:
    """Show a value as a message may hold it, however large it is."""
    text = SHORT.repr(value)
    return text if len(text) <= LONGEST_VALUE else f"{text[:LONGEST_VALUE]} ..."


SHORT = reprlib.Repr()
SHORT.maxstring = SHORT.maxother = SHORT.maxlong = 80


class SceneError(MechanismError):
    """The scene, or the file it stands in, is not one that can be analysed.

    Parameters
    ----------
    message
        What was found and what is expected.
    place
        Where in the scene, as a dotted path ("links.coupler.points.A").
    line
        Line of the scene file, where it could be found.
    hint
        What to do about it.

    Examples
    --------
    >>> try:
    ...     fm.Material(modulus="71 kg", density=2714)
    ... except fm.SceneError as error:
    ...     print(error.place)
    modulus
    """

    def __init__(self, message: str, *, place: str = "", line: int | None = None, hint: str = "") -> None:
        self.message, self.place, self.line, self.hint = message, place, line, hint
        where = place + (f" (line {line})" if line else "")
        text = f"{where}: {message}" if where else message
        super().__init__(f"{text}. {hint}" if hint else text)


class TooLargeError(SceneError):
    """The scene asks for more than memory, or a solver, holds."""


class AssemblyError(MechanismError):
    """The links cannot be put together at some drive angle."""


class SolverError(MechanismError):
    """A linear or eigenvalue solver did not converge, or its answer is not accurate."""


class DerivativeError(SolverError):
    """A motion has no derivatives, or they do not follow from the equation linearised about it."""


class UnstableError(SolverError):
    """A periodic motion is unstable: small disturbances grow, so that a machine leaves it."""


class UnresolvedError(SolverError):
    """Steps or a mesh too coarse for an answer, or for an accurate one: finer ones may give it."""


class ResultError(MechanismError):
    """A result file cannot be read or written, or a result does not hold what is asked for."""


class StrangeError(ResultError):
    """A file of the kind that is asked for holds what the program has not written."""


class ViewError(MechanismError):
    """A picture or an animation cannot be made on this machine."""


def percent_of_error(share: float) -> str:
    """Write an error in percent; from 100 % on no more than that is known of it."""
    return percent(share) if share < 1 else "100 % or more"


def percent(share: float, digits: int = 2) -> str:
    """Write a share in percent, rounded to some digits and without an exponent where it is large."""
    value = float(f"{100 * share:.{digits}g}")
    return f"{value:.0f} %" if value >= 10**digits else f"{value:.{digits}g} %"
