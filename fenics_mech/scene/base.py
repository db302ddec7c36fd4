"""The base of everything in a scene: frozen, and unknown keys are refused."""

from __future__ import annotations

from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

Name = Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_\-]*$", max_length=100)]
PointName = Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_\-]*\.[A-Za-z_][A-Za-z0-9_\-]*$")]


class Part(BaseModel):
    """A frozen piece of a scene."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)
