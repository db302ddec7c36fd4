"""Tables for people: effects, the overview of a scene file."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from rich import box
from rich.console import Group, RenderableType
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from fenics_mech.effects.effect import Choice
from fenics_mech.effects.known import GRAVITY
from fenics_mech.errors import percent
from fenics_mech.machine.reach import Range
from fenics_mech.scene import Scene
from fenics_mech.scene.answer_units import AnswerUnits
from fenics_mech.scene.applied_loads import LineLoad
from fenics_mech.scene.consistency import mobility
from fenics_mech.scene.in_space import SpatialScene
from fenics_mech.scene.springs_dampers import HingeDamper, HingeSpring, Line

NO_GRAVITY = 'gravity: none is stated; gravity = [0, "-9.81 m/s^2"] lets it act'
BEST = math.pi / 2 - 1e-4  # of a transmission angle (rad)


def effects_table(choices: Sequence[Choice]) -> Group:
    """Tabulate the effects that act or whose influence is known: size, whether they act, and what they are."""
    lines = [Text("Influences are shares of the strains. --compare measures them, by runs with effects added in turn.")]
    table = table_of("Effects with effects = 'auto'", "effect", "influence", "acts", "what it is")
    table.columns[-1].justify = "left"
    for choice in choices:
        if choice.size is None and not choice.acts and not choice.missing:
            continue
        size = "" if choice.size is None else percent(choice.size)
        acts = Text("yes", style="bold green") if choice.acts else Text("no")
        if choice.missing:
            acts = Text("lacks data", style="bold red")
            lines.append(Text(f"{choice.effect.name} would act, but lacks data: {choice.missing}", style="bold red"))
        if holder := next((c.effect.name for c in choices if c.acts and c.effect.replaces == choice.effect.name), ""):
            acts = Text(f"included in {holder}")
        effect = choice.effect
        unstated = effect.name == GRAVITY and not choice.acts
        table.add_row(effect.name, size, acts, Text(NO_GRAVITY if unstated else effect.meaning))
    return Group(table, *lines)


def scene_overview(scene: Scene, reach: Range) -> Group:
    """Tell what is in a scene, how far its drive turns, and where it transmits force worst."""
    table = table_of("Members", "member", "length (m)", "section", "material", "elements")
    for label, (_, member) in scene.members().items():
        mesh = member.mesh or scene.mesh
        elements = len(mesh.stations) - 1 if mesh.stations else mesh.elements
        length = f"{math.dist(*scene.member_ends(label)):.6g}"
        table.add_row(escape(label), length, member.section, member.material, str(elements))
    counted = {"link": len(scene.links), "joint": len(scene.joints)}
    counts = ", ".join(f"{count} {name}{'s' * (count != 1)}" for name, count in counted.items())
    if masses := len(scene.masses):
        counts += f", {masses} point mass{'es' * (masses != 1)}"
    low, high = (f"{np.degrees(limit):.6g}\N{DEGREE SIGN}" for limit in (reach.low, reach.high))
    turns = "The drive turns through the whole cycle." if reach.turns else f"The drive turns from {low} to {high} only."
    if not scene.drives:
        turns = "Nothing drives it" + (", and it is free to move: " + "; ".join(reach.free) if reach.free else "") + "."
    lines: list[RenderableType] = [Text(scene.name, style="bold"), Text(f"{counts}; {drive_of(scene)}")]
    turns += f" Mobility {mobility(scene)} by Gruebler's count."
    lines += [table, _in_si(scene)] if scene.members() else []
    lines += [*map(Text, _acting(scene)), Text(turns)]
    for critical in reach.critical:
        if critical.kind != "worst transmission":
            lines.append(Text(f"{critical.kind} at {_degrees(critical.theta)} ({', '.join(critical.links)})"))
        elif not reach.transmission:
            size = f"{critical.value:.3g} (0: the linkage locks, or can move in two ways)"
            where = f"worst transmission of motion at {_degrees(critical.theta)}: smallest singular value {size}"
            lines.append(Text(f"{where}, {', '.join(critical.links)}"))
    for pair in reach.transmission:
        at = f"at drive angle {_degrees(pair.theta)} (90\N{DEGREE SIGN} is best)" if pair.angle < BEST else "always"
        text = f"transmission angle at joint {pair.joint} ({', '.join(pair.links)})"
        lines.append(Text(f"{text}: {'at worst ' * (pair.angle < BEST)}{_degrees(pair.angle)} {at}"))
    return Group(*lines)


def _in_si(scene: Scene) -> Table:
    """Tabulate mass and stiffness of the members, in which a wrong unit shows."""
    columns = "member", "mass (kg)", "EA (N)", "EI (N m^2)", "radius of\ngyration (mm)"
    table, s = table_of("The same in SI, at mid-span where they vary", *columns), np.linspace(0, 1, 101)
    for label in scene.members():
        rigidity = scene.rigidity(label, s)
        density = rigidity.line_density
        mass = float(np.mean((density[1:] + density[:-1]) / 2)) * math.dist(*scene.member_ends(label))
        ea, ei = float(rigidity.axial[50]), float(rigidity.bending[50])
        table.add_row(escape(label), number(mass), number(ea), number(ei), number(1e3 * math.sqrt(ei / ea)))
    return table


def _acting(scene: Scene) -> Iterator[str]:
    """Say which rigid links, masses, springs, dampers and joint laws there are, which loads act in SI, and cases."""
    for name, link in scene.links.items():
        if body := link.rigid:
            yield (
                f"rigid link {name}: {number(body.mass)} kg and {number(body.inertia)} kg m^2, "
                f"centre of mass {_pair(body.centre)} m"
            )
    for name, mass in scene.masses.items():
        turning = f" and {number(mass.inertia)} kg m^2" if mass.inertia else ""
        yield f"mass {name}: {number(mass.mass)} kg{turning} at {mass.at}"
    for name, spring in scene.springs.items():
        if isinstance(spring, HingeSpring):
            free = None if spring.angle is None else f"free angle {_degrees(spring.angle)}"
            text, kind = f"{number(spring.stiffness)} N m/rad at joint {spring.joint}", "angle"
        else:
            free = None if spring.length is None else f"free length {number(spring.length)} m"
            text, kind = f"{number(spring.stiffness)} N/m {_span(spring)}", "length"
        yield f"spring {name}: {text}, {free or f'free {kind} as at drive angle 0'}"
    for name, damper in scene.dampers.items():
        where = f"N m s/rad at joint {damper.joint}" if isinstance(damper, HingeDamper) else f"N s/m {_span(damper)}"
        yield f"damper {name}: {number(damper.damping)} {where}"
    for name, law in scene.joint_laws.items():
        yield f"joint law {name}: {law.kind} at joint {law.joint}"
    yield f"gravity: {_pair(scene.gravity)} m/s^2" if any(scene.gravity) else NO_GRAVITY
    for name, load in scene.loads.items():
        if isinstance(load, LineLoad):
            ends = " to ".join(_pair(end) for end in (load.line, load.line_end) if end is not None)
            what, where = f"{ends} N/m", f"along {load.member}"
        else:
            parts = [f"{_pair(load.force)} N"] * any(load.force) + [f"{number(load.moment)} N m"] * bool(load.moment)
            what, where = " and ".join(parts) or "nothing", f"at {load.at}"
        low, high = map(number, load.factor_range)
        between = "" if load.over_cycle is None else f" from {low} to {high}"
        varies = "" if load.factor is None else f", times a factor{between} ({load.factor.kind})"
        yield f"load {name}: {what} {where}{varies}"
    for case in scene.cases:
        changes = [f"{path} = {value}" for path, value in case.values.items()]
        changes += [f"without {' and '.join(case.off)}"] if case.off else []
        yield f"load case {case.name}: {', '.join(changes) or 'the scene as it stands'}"


def _span(line: Line) -> str:
    return f"from {line.between[0]} to {line.between[1]}"


def _pair(values: tuple[float, float]) -> str:
    return f"({number(values[0])}, {number(values[1])})"


def _degrees(angle: float) -> str:
    """Write an angle in degrees, a whole turn as 0."""
    degrees = round(math.degrees(angle), 3)
    return f"{0 if degrees == 360 else degrees:.6g}\N{DEGREE SIGN}"


def table_of(title: str, first: str, *others: str, caption: str | None = None) -> Table:
    """Make an empty table: its first column to the left, with whole names, the others to the right."""
    look: dict[str, Any] = {"box": box.SIMPLE_HEAD, "pad_edge": False, "title_justify": "left", "title_style": "bold"}
    table = Table(title=title, caption=caption, caption_justify="left", **look)
    table.add_column(first, overflow="fold")
    for column in others:
        table.add_column(column, justify="right")
    return table


def plain_table(*columns: str) -> Table:
    """Make an empty table without lines; columns whose head ends in "<" stand to the left."""
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0), header_style="", caption_justify="left")
    for n, column in enumerate(columns):
        table.add_column(column.removesuffix("<"), justify="left" if column.endswith("<") or not n else "right")
    return table


def rows_table(rows: Mapping[str, str]) -> Table:
    """Write texts beside their names."""
    table = Table.grid(padding=(0, 2))
    for name, text in rows.items():
        table.add_row(name, escape(text))
    return table


def drive_of(scene: Scene | SpatialScene, units: AnswerUnits | None = None) -> str:
    """Say how the scene is driven, in its units of speed or in others."""
    units = units or scene.answer_units
    said = [
        f"joint {drive.joint} " + ("by a periodic law" if drive.speed is None else _speed(drive.speed, units))
        for drive in scene.drives
    ]
    return f"{', '.join(said)}; period {number(scene.period)} s" if said else "no drive"


def _speed(speed: float, units: AnswerUnits) -> str:
    text = f"at {number(units.number(speed, 'speed'))} {units.label('speed')}"
    return text if units.label("speed") == "rpm" else f"{text} ({number(30 * speed / math.pi)} rpm)"


def number(value: float) -> str:
    """Four significant digits, with no exponent from ten thousand up to a million."""
    return f"{value:.0f}" if 1e4 <= abs(value) < 1e6 else f"{value:.4g}"
