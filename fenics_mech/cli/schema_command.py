"""`fenics-mech schema`."""

from __future__ import annotations

import json


def schema() -> None:
    """Print the JSON Schema of scene files."""
    from fenics_mech.scene import schema as scene_schema  # noqa: PLC0415

    print(json.dumps(scene_schema(), indent=2))
