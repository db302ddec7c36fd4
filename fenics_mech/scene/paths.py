"""Values of a scene by dotted paths."""

from __future__ import annotations

from typing import Any

from fenics_mech.errors import SceneError


def place_in(part: Any, path: str, value: Any) -> None:
    """Put a value into nested data, by dotted path; tables on the way are made where they are missing."""
    *parents, last = (int(key) if key.isdecimal() else key for key in path.split("."))
    if "__" in path and path.partition("__")[0] in part:
        hint = f'Write {path.replace("__", ".")!r}: "__" stands for dots in names of arguments only'
        raise SceneError("there is no such part of the scene", place=path, hint=hint)
    try:
        for parent in parents:
            if isinstance(part, dict):
                part.setdefault(parent, {})
            part[parent] = list(part[parent]) if isinstance(part[parent], tuple) else part[parent]
            part = part[parent]
        part[last] = value
    except (KeyError, IndexError, TypeError) as error:
        raise SceneError("there is no such part of the scene", place=path) from error
