"""The errors of fenics_mech: each says what was found, where, what is expected and what to do."""

from __future__ import annotations


class MechanismError(Exception):
    """Base of every error that a user of the program can meet."""


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
    """

    def __init__(self, message: str, *, place: str = "", line: int | None = None, hint: str = "") -> None:
        self.message, self.place, self.line, self.hint = message, place, line, hint
        where = place + (f" (line {line})" if line else "")
        text = f"{where}: {message}" if where else message
        super().__init__(f"{text}. {hint}" if hint else text)


class AssemblyError(MechanismError):
    """The links cannot be put together at some drive angle."""


class SolverError(MechanismError):
    """A linear or eigenvalue solver did not converge, or its answer is not accurate."""


class ResultError(MechanismError):
    """A result file cannot be read or written."""


class ViewError(MechanismError):
    """A picture or an animation cannot be made on this machine."""
