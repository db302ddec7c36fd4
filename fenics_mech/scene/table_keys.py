"""Which keys the table at a place of a scene may have."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, get_args

from pydantic import BaseModel


def table_keys(top: type[BaseModel], location: Sequence[int | str]) -> list[str]:
    """Give the keys of the table at a location of pydantic; of all tables that may stand there."""
    tables = [top]
    for part in location:
        fields = [
            field for table in tables for name, field in table.model_fields.items() if part in (name, field.alias)
        ]
        if fields:
            tables = [table for field in fields for table in _tables(field.annotation)]
    return [field.alias or name for table in tables for name, field in table.model_fields.items()]


def _tables(annotation: Any) -> Iterator[type[BaseModel]]:
    """Give the tables of an annotation: of a union, and what lists and dictionaries hold."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for part in get_args(annotation):
        yield from _tables(part)
