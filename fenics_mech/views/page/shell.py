"""What all pages have in common: one file that loads nothing from anywhere."""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Mapping, Sequence
from importlib.resources import files
from pathlib import Path
from string import Template

from fenics_mech._files import write_whole
from fenics_mech.errors import ViewError
from fenics_mech.views.page.html import Html, json_in_page, tag

ENDINGS = (".html", ".htm")


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
    """Join files that stand beside this module to one script."""
    return "(async () => {\n'use strict';\n" + "".join(source(name) for name in names) + "})();\n"


def source(name: str) -> str:
    """Read a file that stands beside this module."""
    return (files(__package__) / name).read_text(encoding="utf-8")


def policy(script: str) -> Html:
    """Let the browser run this script and no other, load nothing, and send nothing."""
    hashed = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    rules = (
        "default-src 'none'",
        f"script-src 'sha256-{hashed}'",
        "style-src 'unsafe-inline'",
        "img-src data:",
        "base-uri 'none'",
        "form-action 'none'",
    )
    return tag("meta", http_equiv="Content-Security-Policy", content="; ".join(rules))
