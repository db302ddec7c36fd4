"""What other packages add to scenes: shapes of sections, kinds of loads and joint laws, and tables of other keys."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Union

from pydantic import Discriminator, GetCoreSchemaHandler, GetJsonSchemaHandler, Tag, ValidationError, WrapValidator
from pydantic_core import CoreSchema, core_schema

from fenics_mech._plugins import Plugin, plugins
from fenics_mech.errors import SceneError, shortened
from fenics_mech.scene.applied_loads import AnyLoad, LineLoad, Load
from fenics_mech.scene.base import Name, Part
from fenics_mech.scene.first_error import BRANCH, MARKS, tables, tag_of
from fenics_mech.scene.joint_laws import AnyJointLaw, PluggedEffort
from fenics_mech.scene.sections import Section, any_section

METHODS = "rigidity", "shear_stiffness", "check", "effort_at", "factor_at", "computed"  # whose errors name the plugin


def add_kinds(scene: type[Part]) -> None:
    """Let scenes state the sections, loads and joint laws of other packages."""
    shapes = [_kind(one, "shape", Section) for one in plugins("sections")]
    of_key: dict[str, Any] = {
        "sections": any_section(*shapes) if shapes else None,
        "loads": _among(AnyLoad, {one: _kind(one, "kind", Load, LineLoad) for one in plugins("loads")}),
        "joint_laws": _among(AnyJointLaw, {one: _kind(one, "kind", PluggedEffort) for one in plugins("joints")}),
    }
    for key, kinds in of_key.items():
        if kinds is not None:
            kept: Any = dict[Name, kinds]  # type: ignore[valid-type]
            scene.model_fields[key].annotation = kept
    if any(kinds is not None for kinds in of_key.values()):
        scene.model_rebuild(force=True)


def _kind(plugin: Plugin, tag: str, *bases: type[Part]) -> type[Any]:
    """Load a class of sections, loads or joint laws, whose tag is the plugin's name and whose errors name it."""
    kind: type[Part] = plugin.load(Part)
    names = " or ".join(base.__name__ for base in bases)
    if not issubclass(kind, bases):
        raise plugin.refused(f"gives {kind.__name__} where a class derived from {names} is expected")
    taken = {*MARKS, *(tag_of(other, tag) for other in tables(Part) if other.__module__.startswith("fenics_mech."))}
    if tag_of(kind, tag) != plugin.name or plugin.name in taken:
        raise plugin.refused(f"needs a field `{tag}: Literal[{plugin.name!r}] = {plugin.name!r}`, a name not yet taken")
    for name in METHODS:
        if hasattr(kind, name):
            setattr(kind, name, plugin.blamed(getattr(kind, name)))
    return kind


def _among(own: Any, plugged: dict[Plugin, type[Part]]) -> Any:
    """Give the type of what the program knows by itself, or of a kind of another package; None where there is none."""
    if not plugged:
        return None
    kinds = {kind: f"{BRANCH}{plugin.name}" for plugin, kind in plugged.items()}
    of_name = {plugin.name: f"{BRANCH}{plugin.name}" for plugin in plugged}

    def tag(value: Any) -> Any:
        if not isinstance(value, Mapping):
            return kinds.get(type(value), BRANCH)
        kind = value.get("kind")
        return of_name.get(kind, BRANCH) if isinstance(kind, str) else BRANCH

    tagged = [Annotated[kind, WrapValidator(_reader(plugin)), Tag(kinds[kind])] for plugin, kind in plugged.items()]
    return Annotated[Union[Annotated[own, Tag(BRANCH)], *tagged], Discriminator(tag)]


def _reader(plugin: Plugin) -> Any:
    """Give what reads a kind of a package; errors that its checks do not mean as answers name the plugin."""

    def read(data: Any, handler: Any) -> Any:
        try:
            part = handler(data)
        except (ValidationError, SceneError):
            raise
        except Exception as error:
            raise plugin.failed("cannot read its keys", error) from error
        computed = part.computed() if isinstance(part, Load | LineLoad) else {}
        for key, value in computed.items():
            if key in part.model_fields_set and getattr(part, key) != value:
                raise ValueError(f"`{key}` follows from the other keys of a load of kind {plugin.name!r}: leave it out")
        return part.model_copy(update=computed)

    return read


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
