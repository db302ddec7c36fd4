"""The commands, snippets and scenes that the documents show: found, run, and their shown output made anew.

`python tests/documents.py` rewrites every output block of the documents by what their commands print today.
An output is a block of `text` after a block of `bash` or `python`. It shows what the last line prints.
"""

from __future__ import annotations

import contextlib
import io
import math
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from unittest import mock

from typer.testing import CliRunner

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
FENCE = re.compile(r"^( *)```([^\n`]*)\n(.*?)^ *```$", flags=re.DOTALL | re.MULTILINE)
WIDTH = "90"
# Commands that take long are parsed while a page runs. A slow test runs them, but those of `NOT_RUN`.
LONG = (
    "follow",
    "animate",
    "sweep",
    "compare",
    "refine",
    "fatigue",
    "optimise",
    "identify",
    "spread",
)
LONG_OPTIONS = ("--compare", "--tol", "--refine-peaks")
MINUTES = "takes minutes"
INSTALLS = "installs what the tests run on"
TESTS = "runs these tests"
NOT_RUN = {  # shown commands, and why no test of the documents runs them
    "fenics-mech follow demos/four_bar.toml --over drive.speed=20:60 -o out/branch": f"{MINUTES}: see test_follow.py",
    ".venv/bin/python -m benchmarks cost demos/four_bar.toml --quick -o out/cost": f"{MINUTES}: see test_cost.py",
    ".venv/bin/python -m benchmarks scaling --quick -o out/scaling": f"{MINUTES}: see test_scaling.py",
    'fenics-mech sweep demos/four_bar.toml --over "drive.speed=100 rpm:300 rpm:51" -o out/speeds': MINUTES,
    'fenics-mech sweep demos/four_bar.toml --over "drive.speed=10:50:161" -o out/campbell': MINUTES,
    'fenics-mech sweep press.toml --over "drive.speed=250 rpm:650 rpm:41" -o speeds': MINUTES,
    'fenics-mech sweep thicker.toml --over "drive.speed=250 rpm:650 rpm:41" -o thicker': MINUTES,
    "fenics-mech optimise lighter.toml -o lighter": f"{MINUTES}: docs/studies.py runs it",
    "fenics-mech identify damping.toml record.csv -o damping": f"{MINUTES}: docs/studies.py runs it",
    ".venv/bin/python -m tests.validation": "see tests/validation/test_check.py",
    "make run": INSTALLS,
    "make test": TESTS,
    "make test-all": TESTS,
    "make docs": "CI builds the documents by itself",
    "make matrix": "builds whole systems",
    "make bench": "reports times and asserts nothing",
    ".venv/bin/python -m pytest tests/effects/test_gravity.py": TESTS,
    '.venv/bin/python -m pytest -n auto --dist loadfile -m "not slow"': TESTS,
    '.venv/bin/python -m pytest -n auto --dist loadfile -m "not long"': TESTS,
    "conda install -c conda-forge fenics-dolfinx slepc4py h5py": INSTALLS,
    "pip install .": INSTALLS,
    "pip install '.[solver]'": INSTALLS,
}


@dataclass(frozen=True)
class Block:
    """A fenced block of a page.

    Parameters
    ----------
    language
        What stands behind its fence.
    text
        Its lines, without the indent of the fence.
    start, end
        Where its lines stand in the page.
    """

    language: str
    text: str
    start: int
    end: int


def pages() -> list[Path]:
    """Give every document in which commands and snippets are shown."""
    written = [page for page in sorted(DOCS.rglob("*.md")) if not {"generated", "_build"} & set(page.parts)]
    return [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *written]


def blocks(page: Path) -> list[Block]:
    """Give the fenced blocks of a page."""
    found = FENCE.finditer(page.read_text())
    return [Block(m[2], re.sub(rf"^{m[1]}", "", m[3], flags=re.MULTILINE), m.start(3), m.end(3)) for m in found]


def folder(place: Path) -> None:
    """Put into a folder what the documents' commands look for: the demos, the drawings, the scenes of the tutorial."""
    for name in ("demos", "meshes"):
        (place / name).symlink_to(ROOT / name)
    shutil.copy(DOCS / "tutorial" / "press.toml", place)
    (place / "gauge.csv").write_text("angle_deg,strain\n0,-0.8e-4\n90,0.7e-4\n180,0.8e-4\n270,0.2e-4\n")
    for name, old, new in (
        ("slow", "300 rpm", "30 rpm"),
        ("fast", "300 rpm", "500 rpm"),
        ("thicker", 'height = "4 mm"', 'height = "5 mm"'),
    ):
        (place / f"{name}.toml").write_text((place / "press.toml").read_text().replace(old, new))


def is_long(command: str) -> bool:
    """Whether a command of the program takes long."""
    if not command.startswith("fenics-mech "):
        return False
    words = shlex.split(command)[1:]
    return words[0] in LONG or not set(words).isdisjoint(LONG_OPTIONS)


def commands(page: Path) -> list[str]:
    """Give the commands that a page shows in blocks, without what is said beside them."""
    shown = [block for block in blocks(page) if block.language in ("bash", "")]
    lines = (line.partition("  #")[0].strip() for block in shown for line in block.text.splitlines())
    return [line for line in lines if line and not line.startswith("#")]


def printed(command: str, parse: bool = True) -> str:
    """Run one line of shell and give what it prints; the program's own command runs in this process.

    A command that takes long is only parsed, unless `parse` is false.
    """
    own, *filters = command.split("|")
    words = shlex.split(own.replace("2>&1", ""))
    if words[:3] == ["mpirun", "-n", "4"]:
        words = words[3:]
    if words[0] != "fenics-mech":
        return subprocess.run(["bash", "-c", command], check=True, capture_output=True, text=True).stdout
    text = _command([*words[1:], "--help"] if parse and is_long(own) else words[1:])  # options are looked at first
    if filters:
        text = subprocess.run(
            ["bash", "-c", "|".join(filters)], check=True, capture_output=True, text=True, input=text
        ).stdout
    return text


def _command(words: list[str]) -> str:
    """Run the program; as on a terminal, it leaves no line of progress, however long it takes."""
    from fenics_mech.cli import app
    from fenics_mech.errors import MechanismError

    with mock.patch("fenics_mech._console.PAUSE", math.inf):
        done = CliRunner().invoke(app, words, env={"COLUMNS": WIDTH, "TERM": "dumb"})
    if isinstance(done.exception, MechanismError):
        return f"{done.output}error: {done.exception}\n"  # its warnings come first
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    if done.exit_code:
        raise AssertionError(f"{' '.join(words)}: {done.output}")
    return "\n".join(line.rstrip() for line in done.output.splitlines()) + "\n"


def run(page: Path) -> list[tuple[Block, str]]:
    """Run what a page shows, from top to bottom, and give each output block with what is printed in its place."""
    names: dict[str, object] = {}
    found, said = [], ""
    for block in blocks(page):
        if block.language == "bash":
            said = [printed(line) for line in block.text.splitlines() if line and not line.startswith("#")][-1]
        elif block.language == "python":
            with contextlib.redirect_stdout(io.StringIO()) as out:
                exec(compile(block.text, f"{page.name}", "exec"), names)
            said = out.getvalue()
        elif block.language == "text" and said:
            found.append((block, said))
            said = ""
    return found


def rewrite(page: Path) -> None:
    """Put what is printed today into the output blocks of a page."""
    text = page.read_text()
    for block, said in reversed(run(page)):
        text = text[: block.start] + said.strip("\n") + "\n" + text[block.end :]
    page.write_text(text)


if __name__ == "__main__":
    asked = [Path(name).resolve() for name in sys.argv[1:]] or [
        page for page in pages() if "```text" in page.read_text()
    ]
    with tempfile.TemporaryDirectory() as place, contextlib.chdir(place):
        folder(Path(place))
        os.environ["COLUMNS"] = WIDTH
        for one in asked:
            rewrite(one)
