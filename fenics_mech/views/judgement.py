"""One reason why the numbers of a result may be used, or not."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Level = Literal["bad", "warn", "good", "note"]


@dataclass(frozen=True)
class Judgement:
    """One reason why numbers may be used, or not."""

    level: Level  # "good", "note" (not examined), "warn" (use with care) or "bad" (do not use)
    title: str  # the reason in a few words, without a capital letter
    text: str  # sentences with numbers, and with what to change
    about: str = "theory"  # what is judged: "theory", "stability" or "error"
