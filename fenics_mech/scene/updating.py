"""Scene files of earlier versions: keys that have gone, and the text of a file without them."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Mapping
from copy import deepcopy
from typing import Any

ALL_NODES = "members keep all their nodes, of which one to ten are exact to many digits"
GONE = {  # keys of `analysis`: the value that said nothing, and what holds now
    "reduction": ("none", ALL_NODES),
    "cutoff": ("auto", ALL_NODES),
    "scheme": ("radau", "steps have Radau points"),
    "tension": ("rigid", "axial forces are those of loads and rigid motion; with 'large-rotations' they settle"),
}
VALUE = r"""("(?:[^"\\\n]|\\.)*"|'[^'\n]*'|[^\s,#}\]]+)"""  # a text, a number, or true or false


def without_neutral(analysis: Mapping[str, Any]) -> dict[str, Any]:
    """Give the table `analysis` without those gone keys whose value said nothing, as results of before hold them."""
    return {key: value for key, value in analysis.items() if key not in GONE or value != GONE[key][0]}


def updated(text: str) -> tuple[str, dict[str, str]]:
    """Give the text of a scene file without keys that have gone. Comments and all other lines stay."""
    left_out = {}
    for key, (_, now) in GONE.items():
        data = tomllib.loads(text)
        if not isinstance(analysis := data.get("analysis"), dict) or key not in analysis:
            continue
        wanted = deepcopy(data)
        del wanted["analysis"][key]
        for shorter in _without(text, key):
            if _tables(shorter) in (wanted, {name: table for name, table in wanted.items() if table != {}}):
                text, left_out[key] = shorter, now
                break
    return text, left_out


def _without(text: str, key: str) -> Iterator[str]:
    """Give texts without one statement of a key: with its whole line, or with the comma after or before it."""
    statement = rf"(?:analysis\s*\.\s*)?{key}[ \t]*=[ \t]*{VALUE}"
    for form in (
        rf"^[ \t]*{statement}[ \t]*(?:#.*)?(?:\n|\Z)",
        rf"{statement}[ \t]*,[ \t]*",
        rf",[ \t]*{statement}",
        statement,
    ):
        for match in re.finditer(form, text, flags=re.MULTILINE):
            yield text[: match.start()] + text[match.end() :]


def _tables(text: str) -> dict[str, Any] | None:
    """Give the tables of a text; None where it is not TOML."""
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return None
