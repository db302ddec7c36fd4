"""What is made from a mesh, or from a layout on it, and is the same for all scenes that share it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeVar

Made = TypeVar("Made")


@dataclass(frozen=True)
class MadeOnce:
    """Something from which other things are made, each once."""

    _made: dict[str, Any] = field(init=False, repr=False, default_factory=dict)

    def once(self, what: str, make: Callable[[], Made]) -> Made:
        """Make something, or give it as it was made before.

        Parameters
        ----------
        what
            What it is.
        make
            Makes it.
        """
        if what not in self._made:
            self._made[what] = make()
        return self._made[what]
