"""What is made once: from a mesh or a layout for all scenes that share it, and for scenes that state the same."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, ParamSpec, TypeVar

Made = TypeVar("Made")
Given = ParamSpec("Given")


@dataclass(frozen=True)
class MadeOnce:
    """Something from which other things are made, each once."""

    _made: dict[str, Any] = field(init=False, repr=False, default_factory=dict)

    def once(self, what: str, make: Callable[[], Made]) -> Made:
        """Make something, or give it as it was made before."""
        if what not in self._made:
            self._made[what] = make()
        return self._made[what]


class LastMade:
    """The last things of one kind that were made, given again for what they were made from."""

    def __init__(self, most: int) -> None:
        self.most = most
        self._made: list[tuple[Any, Any]] = []

    def once(self, needed: Any, make: Callable[Given, Made], *given: Given.args, **options: Given.kwargs) -> Made:
        """Make something, or give it as it was made from what is equal."""
        for known, made in self._made:
            if known == needed:
                return made  # type: ignore[no-any-return]
        found = make(*given, **options)
        self._made = [*self._made, (needed, found)][-self.most :]
        return found
