"""The base of everything in a scene: frozen, and unknown keys are refused."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict


class Part(BaseModel):
    """A frozen piece of a scene."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)
