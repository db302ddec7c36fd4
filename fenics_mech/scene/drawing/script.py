"""What gmsh scripts (.geo) may say: a scene file is data, and so is its drawing.

Gmsh's language can run programs, read and write files. Its commands are words before a string, or words that begin with
a capital. So strings may only name groups, and of the capitalised words only those that draw are let through.
"""

from __future__ import annotations

import re

from fenics_mech.errors import SceneError

DRAWING_WORDS = {
    "Point", "Line", "Curve", "Circle", "Ellipse", "Spline", "BSpline", "Bezier", "Physical", "SetFactory",
    "Transfinite", "Using", "Progression", "Bump", "Characteristic", "Length", "MeshSize",
    "Translate", "Rotate", "Symmetry", "Dilate", "Duplicata", "Boundary", "Coherence", "Delete", "Recursive", "Reverse",
    "For", "In", "EndFor", "If", "ElseIf", "Else", "EndIf", "DefineConstant", "LinSpace", "LogSpace",
    "Pi", "Abs", "Fabs", "Sqrt", "Exp", "Log", "Log10", "Sin", "Cos", "Tan", "Asin", "Acos", "Atan", "Atan2",
    "Sinh", "Cosh", "Tanh", "Hypot", "Floor", "Ceil", "Round", "Fmod", "Modulo", "Min", "Max",
}  # fmt: skip
PIECE = re.compile(
    r"(?P<comment>//[^\n]*|/\*.*?\*/)"
    r"|(?P<option>\b(?:Mesh|Geometry)\s*\.\s*[A-Za-z0-9]+)"
    r"|(?P<group>\b(?:Physical\s+(?:Point|Line|Curve)|SetFactory)\s*\(\s*\"[^\"\n\\]*\")"
    r"|(?P<string>[\"'\\])"
    r"|(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)"
    r"|(?P<word>[A-Za-z_][A-Za-z0-9_]*)",
    re.DOTALL,
)
HINT = "A drawing may define points, curves, physical groups and their meshes; it may not run, read or write anything"


def check_script(text: str, file: str) -> None:
    """Raise `SceneError` unless a gmsh script does nothing but draw; `file` is named in the error."""
    for piece in PIECE.finditer(text):
        word = piece["word"] or ""
        command = re.search("[a-z]", word) and word[0].isupper() and word not in DRAWING_WORDS
        if piece["string"] or command:
            line = text.count("\n", 0, piece.start()) + 1
            found = f"the word {word!r}" if command else f"the character {piece['string']} outside a group's name"
            raise SceneError(f"{file}, line {line}: {found} is not allowed in a drawing", place="drawing", hint=HINT)
