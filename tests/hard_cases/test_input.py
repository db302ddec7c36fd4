"""Hard input: scene files are data, and whatever stands in them is a scene or is refused in one line, at once.

Each case says what is hard and what is expected in the message. No case may take memory or time to be refused.
"""

import os
import random
import re

import numpy as np
import pytest

from fenics_mech.effects import active
from fenics_mech.errors import MechanismError, SceneError
from fenics_mech.scene import load, parse
from fenics_mech.scene.drawing import completed
from fenics_mech.scene.formulas.expression import FUNCTIONS, Formula, Jet
from fenics_mech.scene.formulas.interval import INTERVAL_FUNCTIONS, Interval, unbounded_at

LOAD = '\n[loads.p]\nat = "coupler@0.5"\nforce = [1, 0]\n'
SPRINGS = "\n[springs]\n"


def factor(text):
    return lambda demo: demo + LOAD + f"factor = {text}\n"


def formula(text):
    return factor(f'{{ kind = "expression", formula = "{text}" }}')


def instead(old, new):
    def changed(demo):
        assert old in demo
        return demo.replace(old, new)

    return changed


def before(text):
    return lambda demo: text + "\n" + demo.replace('effects = "auto"', "").replace("gravity = ", "#")


def after(text):
    return lambda demo: demo + text


CASES = {
    # sizes
    "elements": (instead("elements = 3", "elements = 1e9"), "1000000000 elements in one member"),
    "nodes": (instead("elements = 3", f"stations = {[k / 1e5 for k in range(100_001)]}"), "100000 elements"),
    "stations": (instead("[analysis]", "[analysis]\nstations = 1e9"), "less than or equal to 10001"),
    "sub-intervals": (instead("sub_intervals = 360", "sub_intervals = 1e9"), "less than or equal to 1000000"),
    "harmonics": (instead("[analysis]", "[analysis]\nharmonics = 1e9"), "less than or equal to 10000"),
    "stages": (instead("[analysis]", "[analysis]\nstages = 1000000000"), "less than or equal to 9"),
    "long name": (
        lambda demo: 'name = "' + "x" * 10**6 + '"\n' + demo.replace("name =", "#"),
        "at most 200 characters",
    ),
    "long table": (factor(f'{{ kind = "table", angles = {[0] * 150_000}, values = [] }}'), "at most 100000 entries"),
    "many links": (
        after("".join(f"\n[links.l{k}]\npoints = {{ A = [0, 0] }}\nrigid = {{}}" for k in range(600))),
        "at most 500 entries",
    ),
    # TOML
    "no quotes": (before("effects = auto"), "Write texts, names and numbers with a unit in quotes"),
    "key twice": (before('name = "a"\nname = "b"'), "The same key stands twice"),
    "no list": (before("gravity = 9.81"), "must be a list in square brackets, found 9.81"),
    "deep arrays": (before("gravity = " + "[" * 10**5 + "]" * 10**5), "not valid TOML"),
    "deep tables": (before("gravity = " + "{a = " * 10**5 + "1" + "}" * 10**5), "not valid TOML"),
    "deep key": (before("gravity" + ".a" * 10**5 + " = 1"), "more than 30 parts"),
    "5000 digits": (before("gravity = [0, " + "9" * 5000 + "]"), "not valid TOML"),
    "4000 digits": (before("gravity = [0, " + "9" * 4000 + "]"), "at most 1e+30"),
    "zero byte": (after("\x00"), "not valid TOML"),
    "control characters": (before('"\\u001b[31mred\\nline" = 1'), r"\x1b[31mred\nline"),
    # numbers and quantities
    "not a number": (before("gravity = [nan, 0]"), "finite number"),
    "infinite": (before("gravity = [0, -inf]"), "finite number"),
    "tower of powers": (instead('"71 GPa"', '"9**9**9 Pa"'), "an exponent is one digit"),
    "power of a power": (instead('"71 GPa"', '"((((((9^9)^9)^9)^9)^9)^9)^9 Pa"'), "an exponent is one digit"),
    "small digits": (instead('"71 GPa"', '"9⁹⁹⁹⁹⁹⁹⁹ Pa"'), "an exponent is one digit"),
    "long quantity": (instead('"71 GPa"', '"' + "9" * 10**6 + '"'), "1000000 characters"),
    # formulas
    "long formula": (formula("sin(" * 200_000 + "1" + ")" * 200_000), "at most 500 characters"),
    "nested formula": (formula("(" * 240 + "1" + ")" * 240), "cannot read the formula"),
    "power in a formula": (formula("9**9**9"), "an exponent is a number of at most 20"),
    "huge number": (formula("1" + "0" * 400), "may not stand in a formula"),
    "no number": (formula("(-8)**0.5"), "not finite"),
    "division by zero": (formula("1/0"), "not finite"),
    "pole between samples": (formula("1/(theta - 3.3)"), "see theta = 3.3"),
    "pole that touches": (formula("1/(theta**2 - 6.6*theta + 10.89)"), "not finite"),
    "pole of the tangent": (formula("tan(theta/2)"), "see theta = 3.14159"),
    "root of a negative": (formula("sqrt(sin(theta))"), "see theta = 3.14159"),
    "formula of a section": (
        instead('area = "0.406 cm^2"', 'shape = "variable"\narea = "1e-5 + 1e-9/(s - 0.33333)**2"'),
        "cannot be shown",
    ),
    "section of a division": (instead('area = "0.406 cm^2"', 'shape = "variable"\narea = "1/0"'), "must be positive"),
    # words
    "kind of factor": (factor('{ kind = "sine" }'), "there is no kind 'sine' here; known are 'harmonics', 'table'"),
    "no kind of factor": (factor("{ start = 1 }"), "must be a table with a `kind`"),
    "effects in a string": (before('effects = "coupling"'), "a list of names such as [\"coupling\"], found 'coupling'"),
    "misspelled stiffness": (after(SPRINGS + 's = { joint = "C", stifness = 1 }'), "Did you mean 'stiffness'?"),
    "misspelled between": (
        after(SPRINGS + 's = { betwen = ["a.A", "b.B"], stiffness = 1 }'),
        "Did you mean 'between'?",
    ),
    "misspelled gravity": (before("gravitty = [0, 1]"), "Did you mean 'gravity'?"),
    "key of another table": (instead("[analysis]", "[analysis]\nspeed = 1"), "unknown key 'speed'. Remove it or"),
    "key of no table": (instead("[analysis]", "[analysis]\ntolerance = 1e-3"), "belongs above the first [table]"),
    "angles in degrees": (
        factor('{ kind = "table", angles = [0, 90, 300], values = [0, 1, 0] }'),
        "found 0 to 17188.7 deg; without a unit they are rad",
    ),
    "spring nowhere": (after(SPRINGS + "s = { stiffness = 1 }"), "neither `between`, two points, nor `joint`"),
    "shape that is a number": (instead("[sections.strip]", "[sections.strip]\nshape = 3"), "no such shape of section"),
    "section that is a number": (before("sections = 3\n[x]"), ""),
}


@pytest.mark.parametrize("case", CASES)
def test_hard_scene_is_refused_in_one_line(case, demo_text):
    damage, message = CASES[case]
    with pytest.raises(SceneError) as caught:
        parse(damage(demo_text), file="hard.toml")
    text = str(caught.value)
    assert text.startswith("hard.toml")
    assert message in text
    assert len(text) < 1200
    assert text.isprintable()


@pytest.mark.parametrize("name", ["springs", "dampers", "motor", "gravity", "loads", "impulses", "damping"])
def test_effect_that_is_named_but_not_stated_is_refused(seed, name):
    """Naming "motor" would couple rigid and elastic motion, naming "springs" do nothing, both without a word."""
    with pytest.raises(SceneError, match=r"nothing in the scene states it\. It acts by"):
        active(seed.changed(effects=(name,), damping={}))


def test_effect_that_is_misspelled_is_guessed(seed):
    with pytest.raises(SceneError, match=r"no effect 'vibrations'. Did you mean 'vibration'\? Known"):
        active(seed.changed(effects=("vibrations",)))


def test_effect_that_is_named_and_stated_acts(seed):
    scene = seed.changed(effects=("springs", "gravity"), gravity=(0, -9.81))
    scene = scene.changed(springs={"s": {"joint": "C", "stiffness": 1.0}})
    assert {"springs", "gravity"} <= {effect.name for effect in active(scene)}


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-8"])
def test_mark_at_the_start_of_a_file_is_passed_over(tmp_path, demo_text, encoding):
    (tmp_path / "scene.toml").write_text(demo_text.replace("\n", "\r\n"), encoding=encoding)
    assert load(tmp_path / "scene.toml").links.keys() == {"crank", "coupler", "follower"}


@pytest.mark.parametrize("kind", ["pipe", "device", "folder", "UTF-16", "Latin-1", "too large"])
def test_what_is_no_scene_file_is_refused_at_once(tmp_path, demo_text, kind):
    """A pipe that nobody writes to, and a device without an end, would be read for ever."""
    path = tmp_path / "scene.toml"
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "device":
        path.symlink_to("/dev/zero")
    elif kind == "folder":
        path.mkdir()
    elif kind == "too large":
        path.touch()
        os.truncate(path, 10**12)
    else:
        path.write_text("# caf\xe9\n" + demo_text, encoding=kind)
    reason = {"folder": "Is a directory", "too large": "1000000000000 bytes", "pipe": "ordinary", "device": "ordinary"}
    with pytest.raises(SceneError, match=reason.get(kind, "not a UTF-8 text")):
        load(path)


def test_cycle_that_does_not_fit_into_memory_is_refused(seed):
    from fenics_mech import analyse

    with pytest.raises(SceneError, match="GB of memory, and there is"):
        analyse(seed.changed(analysis__sub_intervals=10**6, analysis__stations=10_001))


def test_drawing_that_loops_for_ever_is_ended(tmp_path, monkeypatch):
    from fenics_mech.scene.drawing import gmsh_files as files

    monkeypatch.setattr(files, "DRAWING", files.ReaderLimits(patience=3))
    (tmp_path / "loop.geo").write_text("For i In {0:1e15}\n  x = i;\nEndFor\n")
    with pytest.raises(SceneError, match=r"gmsh cannot read loop\.geo: it takes longer than 3 s"):
        completed({"drawing": "loop.geo"}, tmp_path)


@pytest.mark.parametrize("file", ["a\x00b", "x" * 5000, "/dev/zero", "."])
def test_drawing_that_is_no_file_is_refused(tmp_path, file):
    with pytest.raises(SceneError, match="cannot read"):
        completed({"drawing": file}, tmp_path)


LEGAL = (
    "1/(1 + 0.5*cos(theta))", "1/(1.0000001 + cos(theta))", "sqrt(1 - cos(theta))", "sqrt(1 - cos(theta)**2)",
    "(sin(theta)**2)**0.5", "1/(1 + exp(-100*sin(theta)))", "log(2 + sin(theta))", "(2 + sin(theta))**-1.5",
    "tan(theta/4.001)", "1/(theta**2 - 6*theta + 9.01)", "sqrt(theta - theta**2/(2*pi))", "5", "1/(cos(theta) - 2)**3",
)  # fmt: skip


@pytest.mark.parametrize("text", LEGAL)
def test_formula_that_is_finite_is_let_through(text):
    assert unbounded_at(Formula(text, ("theta",)), 0, 2 * np.pi) is None


def random_formula(chance, depth):
    """Make a formula by chance, of the arithmetic that a formula may have."""
    if depth == 0 or chance.random() < 0.2:
        return chance.choice(["theta", "theta", f"{chance.uniform(-3, 3):.3f}", "pi", "2"])
    parts = random_formula(chance, depth - 1), random_formula(chance, depth - 1)
    return chance.choice(
        [
            f"({parts[0]} {chance.choice('+-*/')} {parts[1]})",
            f"({parts[0]})**{chance.choice(['2', '3', '-1', '-2', '0.5', '-0.5', '1.5', '0'])}",
            f"{chance.choice(list(FUNCTIONS))}({parts[0]})",
            f"-({parts[0]})",
        ]
    )


def test_bounds_hold_all_values_between_them():
    """The definition of an interval extension; 1e-9 for rounding, which the bounds do not count."""
    chance, bounded = random.Random(1989), 0
    with np.errstate(all="ignore"):
        for _ in range(1500):
            rule = Formula(random_formula(chance, 4), ("theta",))
            left = np.linspace(0.01, 6.2, 40)
            right = left + chance.choice([1e-3, 0.1, 1.0])
            found = rule(INTERVAL_FUNCTIONS, theta=Interval(left, right))
            if not isinstance(found, Interval):
                continue
            bounded += int(found.bounded.sum())
            for share in np.linspace(0, 1, 7):
                value = rule.jet(Jet.variable(left + share * (right - left))).value
                slack = 1e-9 * (1 + np.abs(value))
                outside = (value < found.low - slack) | (value > found.high + slack) | np.isinf(value)
                assert not (outside & found.bounded).any(), rule.text
    assert bounded > 10_000


def test_every_error_is_one_printable_line():
    assert str(MechanismError("a\nb\x1b[31m")) == r"a\nb\x1b[31m"


@pytest.mark.parametrize(
    ("written", "meant"),
    [
        ("[drive]", "[drives]"),
        ("[materials.aluminium]", "[material.aluminium]"),
        ("[masses]", "[mass]"),
        ("[joints]", "[joint]"),
        ("[sections.strip]", "[section.strip]"),
        ("members.OA", "member.OA"),
        ("points = { O = [0, 0], A", "point = { O = [0, 0], A"),
        ("O.connect", "O.connects"),
        ("[analysis]", "[analyse]"),
    ],
)
def test_a_table_or_key_nearly_of_that_name_is_suggested_though_another_table_has_the_key(written, meant, demo_text):
    """`drives` is a key of cams, `material` of members, `mass` of points, `member` of slots."""
    right = re.search(r"[a-z]+", written.replace("O.", "").replace("A", ""))[0]
    with pytest.raises(SceneError, match=f"Did you mean '{right}'"):
        parse(demo_text.replace(written, meant, 1), file="hard.toml")
