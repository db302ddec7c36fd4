"""`fenics-mech schema`."""

from __future__ import annotations

import json
from typing import Annotated

import typer


def schema(
    space: Annotated[bool, typer.Option("--space", help="That of scenes in space, with X, Y and Z.")] = False,
) -> None:
    """Print the JSON Schema of scene files."""
    from fenics_mech.scene import schema as scene_schema  # noqa: PLC0415

    print(json.dumps(scene_schema(space), indent=2))
