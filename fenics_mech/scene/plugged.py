"""What other packages add to scenes: shapes of sections, and tables of the keys of their effects."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema, core_schema

from fenics_mech._plugins import Plugin, plugins
from fenics_mech.errors import SceneError, shortened
from fenics_mech.scene.base import Name, Part
from fenics_mech.scene.sections import SHAPES, Section, any_section

METHODS = "rigidity", "shear_stiffness", "check"


def sections() -> tuple[type[Section], ...]:
    """Give the classes of sections of other packages.

    Raises
    ------
    MechanismError
        When one is no section, or its shape has a name that is taken.
    """
    return tuple(_section(plugin) for plugin in plugins("sections"))


def _section(plugin: Plugin) -> type[Section]:
    kind: type[Section] = plugin.load(Section)
    shape = kind.model_fields["shape"].default if "shape" in kind.model_fields else None
    if shape != plugin.name or shape in SHAPES:
        raise plugin.refused(f"needs a field `shape: Literal[{plugin.name!r}] = {plugin.name!r}`, a name not yet taken")
    for name in METHODS:
        setattr(kind, name, plugin.blamed(getattr(kind, name)))
    return kind


def add_sections(scene: type[Part]) -> None:
    """Let scenes state the sections of other packages.

    Parameters
    ----------
    scene
        The class of scenes.
    """
    if kinds := sections():
        kept: Any = dict[Name, any_section(*kinds)]  # type: ignore[misc]
        scene.model_fields["sections"].annotation = kept
        scene.model_rebuild(force=True)


class Tables:
    """The type of ``plugins`` in a scene: tables that other packages read, by name."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        """Read the tables by their classes."""
        return core_schema.no_info_plain_validator_function(_read)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        """Describe the tables of the packages that are installed."""
        tables = {name: handler(table.__pydantic_core_schema__) for name, table in _tables().items()}
        return {"type": "object", "properties": tables, "additionalProperties": False}


def _tables() -> dict[str, type[Part]]:
    """Give the classes of the tables, by name."""
    return {plugin.name: plugin.load(Part) for plugin in plugins("tables")}


def _read(data: Any) -> dict[str, Part]:
    """Read the tables; None leaves one out."""
    if not isinstance(data, Mapping):
        raise SceneError("must be a table", place="plugins")
    found, known = {}, _tables()
    for name, values in data.items():
        if name not in known:
            hint = f"Those that have keys here: {', '.join(known) or 'none'}. Install the package that has it"
            raise SceneError(f"there is no plugin {shortened(name)}", place=f"plugins.{name}", hint=hint)
        try:
            if values is not None:
                found[name] = values if isinstance(values, known[name]) else known[name].read(values)
        except SceneError as error:
            place = f"plugins.{name}.{error.place}".rstrip(".")
            raise SceneError(error.message, place=place, hint=error.hint) from None
    return found
