"""Pieces of HTML whose texts are escaped by construction, and a page of them that loads nothing from anywhere."""

from __future__ import annotations

import base64
import hashlib
import html
import json
from collections.abc import Iterable, Mapping, Sequence
from importlib.resources import files
from pathlib import Path
from string import Template

from fenics_mech._files import write_whole
from fenics_mech.errors import ViewError
from fenics_mech.views.words import sentence, short

ENDINGS = (".html", ".htm")


class Html(str):
    """A piece of a page, in which every text is escaped."""

    __slots__ = ()


EMPTY = Html()


MANY = 5  # columns of a table that a narrow screen shows beside one another


VOID = ("meta", "input", "br")


def tag(name: str, *content: str, **attributes: str | float | bool | None) -> Html:
    """Make an element."""
    written = ""
    for key, value in attributes.items():
        if value is not None and value is not False:
            written += f" {key.rstrip('_').replace('_', '-')}"
            written += "" if value is True else f'="{html.escape(str(value))}"'
    if name in VOID:
        return Html(f"<{name}{written}>")
    return Html(f"<{name}{written}>{join(content)}</{name}>")


def join(parts: Iterable[str]) -> Html:
    """Put pieces behind one another; what is no piece of a page is a text, which is escaped."""
    return Html("".join(part if isinstance(part, Html) else html.escape(part) for part in parts))


def table(head: Sequence[str], rows: Iterable[Sequence[str]], **attributes: str) -> Html:
    """Make a table whose rows begin with their head; on a narrow screen rows of many columns are lists."""
    left = [not i or text.endswith("<") for i, text in enumerate(head)]
    looks = ["t" if to_left else None for to_left in left]
    heads = [tag("th", text.removesuffix("<"), scope="col", class_=look) for text, look in zip(head, looks)]
    body = [row if isinstance(row, Html) else line(row, left, head) for row in rows]
    if len(head) > MANY:
        attributes = {**attributes, "class_": f"{attributes.get('class_', '')} many".strip()}
    top = tag("thead", tag("tr", *heads)) if any(head[1:]) else EMPTY
    return tag("div", tag("table", top, tag("tbody", *body), **attributes), class_="scroll")


def line(cells: Sequence[str], left: Sequence[bool], head: Sequence[str], **attributes: str | float) -> Html:
    """Make a row of a table."""
    first, *rest = cells
    heads = [text.removesuffix("<") if len(head) > MANY else None for text in head]
    others = [tag("td", cell, class_="t" if left[i] else None, data_head=heads[i]) for i, cell in enumerate(rest, 1)]
    return tag("tr", tag("th", first, scope="row", class_="t"), *others, **attributes)


def top(name: str, driven: str) -> Html:
    """Make the head of a page, with its buttons."""
    buttons = (
        tag("button", "Print", id="print", type="button"),
        tag("button", "\N{CIRCLE WITH RIGHT HALF BLACK}", id="theme", type="button", aria_label="dark or light"),
    )
    named = tag("div", tag("h1", sentence(name)), tag("p", driven))
    return tag("header", named, tag("div", *buttons, class_="tools live"), class_="top")


def tile(name: str, value: float, unit: str, where: str) -> Html:
    """Make the tile of a key figure."""
    number = tag("b", short(value), " ", tag("small", unit))
    return tag("div", tag("span", name), number, tag("i", where), class_="tile")


def slider(name: str, step: str) -> Html:
    """Make a slider, whose ends the script sets."""
    return tag("input", id=name, type="range", min="0", step=step)


def plot_frame(name: str) -> tuple[Html, Html]:
    """Make the frame of a plot, with its heading."""
    heads = (tag("b", id=f"{name}-title"), " ", tag("span", id=f"{name}-where"))
    return tag("h3", *heads), tag("div", id=name, class_="plot")


def card(title: str, where: str, plot: str, more: Html = EMPTY) -> Html:
    """Make a card with the frame of a plot, and what stands below it."""
    head = tag("h2", title, " ", tag("small", id=where) if where else EMPTY)
    live_only = "" if more else " live"
    drawn = tag("div", id=plot, class_="plot live") if plot else EMPTY
    return tag("section", head, drawn, more, class_=f"card{live_only}")


def json_in_page(data: object) -> Html:
    """Write data as JSON in which nothing can end the element that it stands in."""
    text = json.dumps(data, separators=(",", ":"), allow_nan=False)
    return Html(text.translate({ord(c): f"\\u{ord(c):04x}" for c in "<>&\u2028\u2029"}))


def page_file(path: str | Path) -> Path:
    """Give the file of a page."""
    path = Path(path)
    if path.suffix.lower() not in ENDINGS:
        raise ViewError(f"{path}: a report's file must end in .html, not in {path.suffix!r}")
    return path


def write_page(path: Path, text: str) -> None:
    """Write a page as a whole."""
    write_whole(path, lambda temporary: temporary.write_text(text, encoding="utf-8"))


def whole_page(template: str, title: str, pieces: Mapping[str, Html], data: object, scripts: Sequence[str]) -> str:
    """Give the text of a page."""
    script = joined(scripts)
    shell = {
        "policy": policy(script),
        "title": tag("title", title),
        "style": source("page.css"),
        "body": Template(source(template)).substitute(pieces),
        "data": json_in_page(data),
        "script": script,
    }
    return Template(source("shell.html")).substitute(shell)


def joined(names: Sequence[str]) -> str:
    """Join files to one script."""
    return "(async () => {\n'use strict';\n" + "".join(source(name) for name in names) + "})();\n"


def source(name: str) -> str:
    """Read a file that stands beside this module, or by "space/name" in the room of views in space."""
    return (files("fenics_mech.views") / (name if "/" in name else f"page/{name}")).read_text(encoding="utf-8")


def policy(script: str) -> Html:
    """Let the browser run this script and no other, load nothing, and send nothing."""
    hashed = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    rules = f"default-src 'none'; script-src 'sha256-{hashed}'; style-src 'unsafe-inline'; img-src data:"
    return tag("meta", http_equiv="Content-Security-Policy", content=f"{rules}; base-uri 'none'; form-action 'none'")
