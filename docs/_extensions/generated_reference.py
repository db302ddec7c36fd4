"""Pages of reference that are made from the program itself, before Sphinx reads the sources.

The scene's keys come from its JSON Schema and the docstrings of its classes, the commands from typer, the variables of
a result and the effects from the tables that the program works with. So no page can be older than the code.
"""

from __future__ import annotations

import inspect
from collections.abc import Iterator
from copy import copy
from pathlib import Path
from typing import Any

from sphinx.application import Sphinx
from typer.testing import CliRunner

import fenics_mech
from fenics_mech.cli import app as command_line
from fenics_mech.effects import EFFECTS
from fenics_mech.recovery.variables import ATTRIBUTES
from fenics_mech.scene import Scene
from fenics_mech.scene.base import Part
from fenics_mech.scene.descriptions import QUANTITY, meaning_of
from fenics_mech.scene.files import bare_schema as scene_schema
from fenics_mech.scene.in_space import SpatialScene
from fenics_mech.scene.sections import Section

FOLDER = Path(__file__).parents[1] / "reference" / "generated"
PAGES: dict[
    str, tuple[str, list[str]]
] = {  # title of each page and the kinds of tables on it; all sections come to theirs by themselves
    "scene": ("Keys at the top of the file", []),
    "links_and_joints": (
        "Ground, links, joints and masses",
        ["Ground", "Link", "Member", "Notch", "RigidBody", "Revolute", "Pin", "Slot", "Prismatic", "Weld", "PointMass"],
    ),
    "sections": ("Materials and sections", ["Material", "StressLife", "Ply", "PolygonPart"]),
    "drives": (
        "Drives and motors",
        [
            *("Drive", "Motor", "Harmonics", "Table", "Expression", "RestToRest"),
            *("TimeTable", "TimeExpression"),
            *("Freedom", "FormulaEffort", "DirectCurrentMotor", "InductionMotor", "SpeedController"),
        ],
    ),
    "loads": (
        "Loads and impulses",
        [
            "Load",
            "LineLoad",
            "Impulse",
            "LoadCase",
            "Pulse",
            "FactorHarmonics",
            "FactorTable",
            "FactorExpression",
            "FactorFormula",
            "FactorTimes",
        ],
    ),
    "springs_and_damping": (
        "Springs, dampers and damping",
        ["LineSpring", "HingeSpring", "LineDamper", "HingeDamper", "Damping", "AirDrag"],
    ),
    "joint_laws": (
        "Laws of joints",
        [
            "Friction",
            "Stop",
            "Clearance",
            "GuideClearance",
            "SideContact",
            "Bushing",
            "GearPair",
            "Cam",
            "JointEffort",
            "Contact",
        ],
    ),
    "analysis": (
        "Mesh, analysis, measurements and traced points",
        ["Mesh", "Analysis", "PoincareSection", "Measurement", "TracedPoint"],
    ),
    "study": ("Studies and design", ["Study", "Variable", "Tied", "Scatter", "Limit", "Target", "Design"]),
}


def setup(app: Sphinx) -> dict[str, bool]:
    """Write the pages when a build begins."""
    app.connect("builder-inited", lambda _: write())
    return {"parallel_read_safe": True, "parallel_write_safe": True}


def write(folder: Path = FOLDER) -> None:
    """Write every generated page into a folder; a page that has not changed is left as it is."""
    folder.mkdir(exist_ok=True)
    made = scene_pages() | {
        "synthesis": tasks(),
        "space": space(),
        "commands": commands(),
        "variables": variables(),
        "effects": effects(),
        "petsc": petsc(),
        "api": api(),
    }
    for name, text in made.items():
        file = folder / f"{name}.md"
        if not file.exists() or file.read_text() != text:
            file.write_text(text)


def scene_pages() -> dict[str, str]:
    """Give the pages of the scene's keys, by name."""
    schema = scene_schema()
    classes = {part.__name__: part for part in _below(Part)}
    kinds, where = schema["$defs"], _places(schema)
    listed = {kind for _, names in PAGES.values() for kind in names}
    sections = [name for name in kinds if issubclass(classes[name], Section)]
    if missing := sorted(set(kinds) - listed - set(sections)):
        raise ValueError(f"name the page of reference for {', '.join(missing)} in PAGES of {__file__}")
    found = {}
    for page, (title, names) in PAGES.items():
        text = [f"# {title}\n"]
        if page == "scene":
            text.append(_table(schema, Scene))
        for name in [*names, *(sections if page == "sections" else [])]:
            text.append(f"({name})=\n## {_words(name)}\n\n{_summary(classes[name])}\n")
            text.append("Stands at " + ", ".join(f"`{place}`" for place in where[name]) + ".\n")
            text.append(_table(kinds[name], classes[name]))
        found[page] = "\n".join(text)
    return found


def tasks() -> str:
    """Give the page of the keys of a synthesis' tasks."""
    text = ["# Tasks of a synthesis\n\nThey stand in files of their own, for `fenics-mech synthesise`.\n"]
    for part in (fenics_mech.FunctionTask, fenics_mech.MotionTask, fenics_mech.Pose, fenics_mech.PathTask):
        text.append(f"({part.__name__})=\n## {_words(part.__name__)}\n\n{_summary(part)}\n")
        text.append(_table(part.model_json_schema(), part))
    return "\n".join(text)


def space() -> str:
    """Give the page of the keys of scenes in space."""
    schema = SpatialScene.model_json_schema()
    classes, where = {part.__name__: part for part in _below(Part)}, _places(schema)
    text = ["# Keys of scenes in space\n\nA scene whose points have three coordinates is one in space.\n"]
    text.append(f"(SpatialScene)=\n## Keys at the top of the file\n\n{_table(schema, SpatialScene)}")
    for name, kind in schema["$defs"].items():
        if name.startswith("Spatial") or name in OWN_OF_SPACE:
            text.append(f"({name})=\n## {_words(name)}\n\n{_summary(classes[name])}\n")
            text.append("Stands at " + ", ".join(f"`{place}`" for place in where[name]) + ".\n")
            text.append(_table(kind, classes[name]))
    return "\n".join(text)


OWN_OF_SPACE = "Misalignment", "PointDamper"


def _below(part: type) -> Iterator[type]:
    for kind in part.__subclasses__():
        yield kind
        yield from _below(kind)


def _words(name: str) -> str:
    """Words of a class's name: "Line load" for LineLoad."""
    spaced = "".join(
        f" {c.lower()}" if c.isupper() and i and not name[i - 1].isupper() else c for i, c in enumerate(name)
    )
    return {"ISection": "I section"}.get(name, spaced)


def _summary(part: type) -> str:
    return inspect.cleandoc(part.__doc__ or "").split("\n\n")[0].replace("\n", " ")


def _table(kind: dict[str, Any], part: type) -> str:
    """Table of the keys of one kind."""
    required = kind.get("required", [])
    lines = ["| key | type | default | meaning |", "| --- | --- | --- | --- |"]
    for key, value in kind["properties"].items():
        default = "required" if key in required else _default(value.get("default"))
        meaning = meaning_of(part, key)
        if not meaning:
            where = "in its class, or in MEANINGS of scene/descriptions.py"
            raise ValueError(f"say what {part.__name__}.{key} means: {where}")
        lines.append("| " + " | ".join(_cell(text) for text in (f"`{key}`", _type(value), default, meaning)) + " |")
    return "\n".join(lines) + "\n"


def _cell(text: str) -> str:
    return text.replace("|", "\\|").replace("\n", " ")


def _default(value: Any) -> str:
    """A default as TOML writes it; a table of defaults stands where its keys are explained."""
    if value is None or value in ([], {}) or isinstance(value, dict):
        return ""
    text = str(value).lower() if isinstance(value, bool) else repr(value).replace("'", '"')
    return f"`{text}`"


def _type(value: dict[str, Any]) -> str:
    """What a key takes, in words."""
    if "$ref" in value:
        name = value["$ref"].rsplit("/", 1)[-1]
        return f"[{_words(name).lower()}](#{name})"
    if QUANTITY in value.get("description", ""):
        unit = value["description"].replace(QUANTITY, "").replace("**", "^").replace("*", " ")
        return "number or share, as `2 %`" if unit == "1" else f"quantity in {unit}"
    if "const" in value or "enum" in value:
        return ", ".join(f"`{choice}`" for choice in value.get("enum", [value.get("const")]))
    for several in ("anyOf", "oneOf"):
        if several in value:
            return " or ".join(dict.fromkeys(_type(one) for one in value[several] if one.get("type") != "null"))
    if "patternProperties" in value:
        return "table of " + " or ".join(_type(one) for one in value["patternProperties"].values())
    if value.get("type") == "array":
        return _array(value)
    if isinstance(value.get("type"), list):
        return " or ".join(_type(value | {"type": one}) for one in value["type"])
    words = {"string": "text", "boolean": "true or false", "number": "number", "integer": "whole number"}
    return words.get(value.get("type", ""), "table") + _range(value)


def _array(value: dict[str, Any]) -> str:
    if "prefixItems" in value:
        parts = list(dict.fromkeys(_type(one) for one in value["prefixItems"]))
        return f"list of {len(value['prefixItems'])}: {', '.join(parts)}"
    return f"list of {_type(value['items'])}" if "items" in value else "list"


def _range(value: dict[str, Any]) -> str:
    words = {"minimum": "at least", "exclusiveMinimum": "above", "maximum": "at most", "exclusiveMaximum": "below"}
    found = [f"{word} {value[key]:g}" for key, word in words.items() if key in value]
    return f", {', '.join(found)}" if found else ""


def _places(schema: dict[str, Any]) -> dict[str, list[str]]:
    """Where in a scene file each kind of table stands."""
    found: dict[str, list[str]] = {}

    def walk(value: Any, place: str) -> None:
        if isinstance(value, list):
            for one in value:
                walk(one, place)
        if not isinstance(value, dict):
            return
        if "$ref" in value:
            name = value["$ref"].rsplit("/", 1)[-1]
            places = found.setdefault(name, [])
            if place not in places:
                places.append(place)
                walk(schema["$defs"][name], place)
            return
        for key, one in value.get("properties", {}).items():
            walk(one, f"{place}.{key}".lstrip("."))
        for one in value.get("patternProperties", {}).values():
            walk(one, f"{place}.NAME")
        for key in ("anyOf", "oneOf", "items", "prefixItems"):
            walk(value.get(key), place)

    walk({key: value for key, value in schema.items() if key == "properties"}, "")
    return found


def petsc() -> str:
    """Give the page of options that PETSc and SLEPc take."""
    lines = ["| option | takes |", "| --- | --- |"]
    for key, value in scene_schema()["properties"]["petsc"]["properties"].items():
        lines.append(f"| `{key}` | {_cell(_type(value))} |")
    return "# Options of PETSc and SLEPc\n\nAll of them are keys of the table `[petsc]`.\n\n" + "\n".join(lines) + "\n"


def api() -> str:
    """Give the page of the names at the top level, from their docstrings."""
    said: dict[str, list[str]] = {"Functions": [], "Results": [], "Errors": []}
    parts = []
    for name in fenics_mech.__all__:
        thing = getattr(fenics_mech, name)
        if isinstance(thing, type) and issubclass(thing, Part):
            parts.append(name)
        elif isinstance(thing, type) and issubclass(thing, Exception):
            said["Errors"].append(f".. autoexception:: fenics_mech.{name}")
        elif isinstance(thing, type):
            said["Results"].append(f".. autoclass:: fenics_mech.{name}\n   :members:")
        elif callable(thing):
            said["Functions"].append(f".. autofunction:: fenics_mech.{name}")
    said["Scene"] = [".. autoclass:: fenics_mech.Scene\n   :members: changed"]
    text = [f"## {title}\n\n```{{eval-rst}}\n" + "\n\n".join(lines) + "\n```\n" for title, lines in said.items()]
    rows = "\n".join(
        f"| [{name}](#{name}) | {_summary(getattr(fenics_mech, name))} |" for name in parts if name != "Scene"
    )
    text.append("## Parts of a scene\n\nThey take the keys of their tables as keyword arguments.\n")
    text.append(f"| class | what it is |\n| --- | --- |\n{rows}\n")
    return "\n".join(["# Names at the top level\n", *text])


def commands() -> str:
    """Give the page of commands, as their `--help` states them."""
    plain = copy(command_line)
    plain.rich_markup_mode = None  # without boxes
    names = sorted(one.name or one.callback.__name__ for one in command_line.registered_commands)
    text = ["# Every command\n"]
    for name in names:
        said = CliRunner().invoke(
            plain, [name, "--help"], env={"COLUMNS": "100"}, terminal_width=100, prog_name="fenics-mech"
        )
        text.append(f"(command-{name})=\n## fenics-mech {name}\n\n```text\n{said.output.strip()}\n```\n")
    return "\n".join(text)


def variables() -> str:
    """Give the page of a result's variables."""
    lines = ["| variable | unit | meaning |", "| --- | --- | --- |"]
    lines += [f"| `{name}` | {unit} | {_cell(meaning)} |" for name, (unit, meaning) in ATTRIBUTES.items()]
    return "# Every variable\n\n" + "\n".join(lines) + "\n"


def effects() -> str:
    """Give the page of effects, from the records that the program finds."""
    text = ["# Every effect\n"]
    for effect in EFFECTS.values():
        by = (
            f"Acts where the scene states it: `{effect.stated_by}`."
            if effect.stated_by
            else f'Acts by name: `effects = ["{effect.name}"]`.'
        )
        text.append(
            f"(effect-{effect.name})=\n## {effect.name}\n\n{effect.meaning[:1].upper()}{effect.meaning[1:]}.\n\n{by}"
        )
        if effect.replaces:
            text.append(f"It holds `{effect.replaces}` in itself.")
        if effect.refuses:
            text.append("Cannot act together with " + ", ".join(f"`{name}`" for name in effect.refuses) + ".")
        text.append(f"Source: {effect.source}.\n")
    return "\n\n".join(text)
