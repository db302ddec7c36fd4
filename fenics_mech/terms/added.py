"""Effects that act by terms of their own: `effects`, which finds them, states them here for machines to ask."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

from fenics_mech.terms.term import Term


class Adding(Protocol):
    """An effect as machines know it; see `effects.effect.Effect`."""

    @property
    def name(self) -> str:
        """Its name."""

    @property
    def stated(self) -> Callable[[Any], bool]:
        """Whether a scene asks for it by what else it states."""

    @property
    def acting(self) -> Callable[[Any], Mapping[str, Term]] | None:
        """Give its terms by name, for a machine of a scene."""


ADDED: list[Adding] = []
