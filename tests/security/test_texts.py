"""Control characters of a scene do not reach the terminal."""

import io

import pytest
from rich.table import Table
from rich.text import Text

from fenics_mech._console import _Console
from fenics_mech.errors import SceneError
from fenics_mech.scene import parse

ESCAPES = {
    "colour": "\x1b[31m",
    "title of the window": "\x1b]0;owned\x07",
    "one character for two": "\x9b31m",
    "end of a C string": "\0",
    "bell": "\a",
    "line": "\n",
    "back": "\b",
    "delete": "\x7f",
    "from right to left": "\u202e",
    "isolate": "\u2066",
    "nothing": "\u200b",
    "end of a line": "\u2028",
}


def quoted(text):
    """Write a text as TOML does."""
    return '"' + "".join(c if c.isprintable() else f"\\u{ord(c):04x}" for c in text) + '"'


def refused(text):
    """Give the error of a scene."""
    with pytest.raises(SceneError) as caught:
        parse(text, file="scene.toml")
    assert str(caught.value).isprintable()
    return str(caught.value)


@pytest.mark.parametrize("case", ESCAPES)
def test_a_name_with_a_control_character_is_refused(case, demo_text):
    line = next(line for line in demo_text.splitlines() if line.startswith("name = "))
    error = refused(demo_text.replace(line, f"name = {quoted('arm' + ESCAPES[case])}"))
    assert error.startswith("scene.toml: name (line ")
    assert f"has the control character {ESCAPES[case][0]!a}" in error


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("[materials.aluminium]", f"[materials.{quoted('alu' + ESCAPES['colour'])}]"),
        ('"71 GPa"', quoted("71 GPa" + ESCAPES["colour"])),
        ("[drive]", f"[{quoted('drive' + ESCAPES['colour'])}]"),
        ('speed = "32.3 rad/s"', f'law = {{ kind = "expression", formula = {quoted(ESCAPES["colour"])} }}\nperiod = 1'),
        ("[drive]", f"[[measurements]]\nfile = {quoted('m.csv' + ESCAPES['colour'])}\nmember = 'coupler'\n[drive]"),
        ("[drive]", f"[petsc]\n{quoted('periodic_' + ESCAPES['colour'])} = 1\n[drive]"),
    ],
)
def test_so_is_any_other_text_or_key(old, new, demo_text):
    assert old in demo_text
    assert "the control character '\\x1b'" in refused(demo_text.replace(old, new))


def test_a_raw_control_character_in_the_file_is_not_echoed(demo_text):
    assert "not valid TOML" in refused(demo_text + "\n\x1b[31m = 1\n")


def test_letters_and_signs_of_any_language_are_let_through(demo_text):
    line = next(line for line in demo_text.splitlines() if line.startswith("name = "))
    name = "Kurbelschwinge Ø 5 µm, 四节机构, четырёхзвенник, β → 1/2\N{NO-BREAK SPACE}mm"
    assert parse(demo_text.replace(line, f'name = "{name}"')).name == name


def test_the_console_prints_no_control_characters():
    """Whoever gave them: libraries quote what they have read."""
    file = io.StringIO()
    console = _Console(file=file, force_terminal=False, width=100)
    table = Table("head\x1b[31m")
    table.add_row("cell\x9b2J")
    for part in ("text\x1b[31m", Text("bold\x1b]0;x\x07", style="bold"), table):
        console.print(part, markup=False)
    assert set(file.getvalue()) >= set("text bold cell")
    assert all(c.isprintable() for c in file.getvalue().replace("\n", ""))
