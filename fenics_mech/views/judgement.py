"""One reason why the numbers of a result may be used, or not."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Level = Literal["bad", "warn", "good", "note"]


@dataclass(frozen=True)
class Judgement:
    """One reason why numbers may be used, or not.

    Parameters
    ----------
    level
        "good", "note" (not examined), "warn" (use with care) or "bad" (do not use).
    title
        The reason in a few words, without a capital letter.
    text
        Sentences with numbers, and with what to change.
    about
        What is judged: "theory", "stability" or "error".
    """

    level: Level
    title: str
    text: str
    about: str = "theory"
