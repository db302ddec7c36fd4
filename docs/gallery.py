"""Make the sections of the gallery and its pictures anew: `python docs/gallery.py`, with names of demos for some only.

It analyses every demo, and those that warn a second time with all effects that they call for. It takes about four
minutes. What stands above the first section stays. The pictures stand beside the demos. That of the pulsating column
is its map of stability, from the sweep in its comment, which takes longer.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

import fenics_mech as fm
from fenics_mech.views.judgements import Judgement, advice, headline, judgements, verdict
from fenics_mech.views.key_figures import key_figures
from fenics_mech.views.motion_figures import freedom_figure, poincare_figure
from fenics_mech.views.reading import Reading
from fenics_mech.views.result_figures import force_figure
from fenics_mech.views.safety_words import safety_sentences
from fenics_mech.views.words import share, short

DOCS = Path(__file__).parent
DEMOS = DOCS.parent / "demos"
PAGE = DOCS / "gallery.md"
SIZE = 800, 600  # pixels of a picture
MADE_BY_SWEEP = "pulsating_column"


def stress(result: fm.Result) -> str:
    """Tell the largest stress with its place."""
    return " ".join(headline(Reading(result)))


def beside_measured(result: fm.Result) -> str:
    """Tell the largest stress, and the frequencies of vibration beside the measured ones of the literature."""
    coupler, follower = (float(result.data["vibration_frequency"].sel(member=m)) for m in ("coupler", "follower"))
    return (
        f"{stress(result)} Its coupler and follower vibrate with {short(coupler)} and {short(follower)} Hz. Turcic "
        "measured 43.7 and 48.9 Hz, as the dissertation reads off his curves in section 7.4."
    )


def deflection(member: str, result: fm.Result) -> str:
    """Tell how far a member leaves the rigid linkage."""
    reading = Reading(result)
    peak = reading.peak(reading.bent, reading.members.index(member))
    size = short(float(reading.bent[peak.k, peak.i, peak.j, 0]))
    place, when = reading.place(peak), reading.at(peak.k)
    return f"{member} bends away from the rigid linkage by up to {size} mm, {place}, at {when}."


def frame(result: fm.Result) -> str:
    """Tell what shakes the frame, and what the largest joint carries."""
    found = key_figures(result)
    force, moment = (abs(found[name]["value"]) for name in ("shaking_force", "shaking_moment"))
    joint, most = max(found["joints"].items(), key=lambda one: one[1]["value"])
    return (
        f"Up to {short(force)} N and {short(moment)} N m act on the frame. "
        f"Joint {joint} carries {short(most['value'])} N: the forces of the supports cancel each other in part."
    )


def governing(result: fm.Result) -> str:
    """Tell the least factor of safety of each load case."""
    told = [
        f"{case} {short(check.factor)} of {check.wanted:g} by {check.mode}"
        for case, one in result.cases.items()
        for _, check in [fm.judge(one).governing]
    ]
    return f"{safety_sentences(result, result.scene.answer_units)[1][0]} The cases have {', '.join(told)}."


def drive(result: fm.Result) -> str:
    """Tell what the drive and the largest joint have to bear."""
    found = key_figures(result)
    joint, most = max(found["joints"].items(), key=lambda one: one[1]["value"])
    torque = found["input_torque"]["value"]
    return f"The drive needs {short(abs(torque))} N m, and joint {joint} carries {short(most['value'])} N."


def members(result: fm.Result) -> str:
    """Tell the three most stressed members."""
    reading = Reading(result)
    said = [f"{reading.members[i]} {short(float(np.abs(reading.stress[:, i]).max()))} MPa" for i in reading.ranked[:3]]
    return f"{', '.join(said)}."


def stability(result: fm.Result) -> str:
    """Tell what is left of a disturbance."""
    judged = of("stability", result)
    return f"The motion is {judged.title}. {judged.text}"


def of(about: str, result: fm.Result) -> Judgement:
    """Give what is judged of theory, stability or error."""
    return next(judged for judged in judgements(result) if judged.about == about)


def slipping(result: fm.Result) -> str:
    """Tell the period and the way of the block on the belt."""
    place, time = result.data["freedom_place"].to_numpy()[:, 0], result.data["time"].to_numpy()
    peaks = time[1:-1][(place[1:-1] > place[:-2]) & (place[1:-1] >= place[2:])]
    period = (peaks[-1] - peaks[0]) / (len(peaks) - 1)
    friction = np.abs(result.data["law_effort"].to_numpy()).max()
    way = 1e3 * np.ptp(place)
    return f"It slips every {short(period)} s, when friction reaches {short(friction)} N. It moves by {short(way)} mm."


def rattling(result: fm.Result) -> str:
    """Tell how the pin hits its bush."""
    push = float(result.data["largest_law_effort"][0])
    caught = max(one["value"] for one in key_figures(result)["joints"].values())
    return (
        f"In one turn it hits {result.data.attrs['contacts_closed']} times, with up to {short(push / 1e3)} kN. "
        f"The positions of the picture catch {short(caught / 1e3)} kN of it."
    )


def motion(result: fm.Result) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Give times, and place and rate of the first freedom."""
    return (
        result.data["time"].to_numpy(),
        *(result.data[f"freedom_{of}"].to_numpy()[:, 0] for of in ("place", "rate")),
    )


def swinging(result: fm.Result) -> str:
    """Tell the period of a pendulum that starts from rest, by the two times at which it is lowest on its first way."""
    time, place, _ = motion(result)
    k = np.flatnonzero((place[:-1] > -np.pi / 2) & (place[1:] <= -np.pi / 2))
    lowest = time[k] - (place[k] + np.pi / 2) * (time[k + 1] - time[k]) / (place[k + 1] - place[k])
    return f"It swings with a period of {short(float(np.diff(lowest)[0]))} s, where small swings would have 1.64 s."


def parting(result: fm.Result) -> str:
    """Tell how fast motions beside a chaotic one part."""
    largest, change = (float(result.data[name][0]) for name in ("lyapunov_exponent", "lyapunov_change"))
    return (
        f"It is chaotic: motions beside it part by a factor of e in about {short(1 / largest)} s. Its largest Lyapunov "
        f"exponent is {short(largest)} 1/s, which changes by {short(change)} 1/s between quarters of the motion."
    )


def shutting(result: fm.Result) -> str:
    """Tell when a door is shut, and how hard it hits."""
    time, place, rate = motion(result)
    k = int(np.argmax(place < 0))
    push = short(float(result.data["largest_law_effort"][0]))
    return f"It is shut after {short(time[k])} s, with {short(-rate[k - 1])} rad/s. The frame bears {push} N m."


def hammering(result: fm.Result) -> str:
    """Tell how hard a hammer hits, and how far it rebounds."""
    _, place, _ = motion(result)
    hit, push = int(np.argmax(place < 0.01)), float(result.data["largest_law_effort"][0])
    return f"It hits with up to {short(push / 1e6)} MN, and rebounds by {short(1e3 * place[hit:].max())} mm."


def starting(result: fm.Result) -> str:
    """Tell when a machine is up to its speed, and which that is."""
    time, _, rate = motion(result)
    late = time[np.argmax(rate > 0.95 * rate[-1])]
    return f"It has 95 % of its speed after {short(late)} s. At the end it turns at {short(rate[-1])} rad/s."


def slowing(result: fm.Result) -> str:
    """Tell by how much a stroke slows a flywheel."""
    time, _, rate = motion(result)
    last = rate[time > time[-1] - 1]
    return f"Over the last second the speed varies by {short(100 * np.ptp(last) / last.mean())} % of its mean."


def walking(result: fm.Result) -> str:
    """Tell the speed of a crank over its last turn."""
    _, place, rate = motion(result)
    last = place > place[-1] - 2 * np.pi
    least, most, joint = rate[last].min(), rate[last].max(), float(result.data["drive_effort"].max())
    return f"The crank turns at {short(least)} to {short(most)} rad/s. The motor gives up to {short(joint)} N m."


def lifting(result: fm.Result) -> str:
    """Tell how far a follower leaves its cam."""
    gap, push = -float(result.data["indentation"].min()), float(result.data["largest_law_effort"][-1])
    return f"It leaves its cam by {short(1e6 * gap)} \N{MICRO SIGN}m, and hits it with {short(push)} N."


def wiping(result: fm.Result) -> str:
    """Tell the torque that a crank needs."""
    return f"The motor needs up to {short(float(result.data['input_torque'].max()))} N m."


def residual(result: fm.Result) -> str:
    """Tell how far the gripper swings in the first dwell."""
    time, bend = result.data["time"].to_numpy(), result.data["deflection"].sel(member="arm").to_numpy()[:, -1]
    dwell = (time > 0.26) & (time < 0.54)
    size = np.linalg.norm(bend[dwell], axis=-1).max()
    return f"In its first dwell the gripper swings on by {short(1e3 * size)} mm."


@dataclass(frozen=True)
class Shown:
    """What the gallery asks of a demo.

    Parameters
    ----------
    question
        What an engineer wants to know of it.
    answer
        Gives the answer from the result.
    """

    question: str
    answer: Callable[[fm.Result], str]


SHOWN = {
    "four_bar": Shown(
        "How much stress does vibration add to the thin strips of the dissertation's machine?", beside_measured
    ),
    "slider_crank": Shown(
        "How far does a slender connecting rod bend under its own inertia?", partial(deflection, "rod")
    ),
    "quick_return": Shown("What does a rocker bear while the crank pin travels along it and its ram returns?", stress),
    "manipulator": Shown("How far do thin arms let the load leave its path?", partial(deflection, "forearm")),
    "jansen": Shown("Which torque and which joints does a pair of walking legs need?", drive),
    "watt": Shown("Which members of a six-bar with ternary links are stressed most?", members),
    "stephenson": Shown(
        "How far does the slender bar between the ternary coupler and the output rocker bend?",
        partial(deflection, "bar"),
    ),
    "counterweighted_rocker": Shown(
        "What is left of the forces on the frame with a counterweight beyond the pivot?", frame
    ),
    "composite_four_bar": Shown("How much stress do links of carbon-fibre laminate have at 600 rpm?", stress),
    "pulsating_column": Shown(
        "Does a column under a pulsating force stay straight, near Mathieu's instability?", stability
    ),
    "joint_laws/belt_friction": Shown("When does a block on a moving belt stick, and when does it slip?", slipping),
    "joint_laws/rattling_slider_crank": Shown("How hard does a piston's pin with 0.5 mm of clearance hit?", rattling),
    "joint_laws/valve_train": Shown("Does a valve stay on its cam at 9000 rpm?", lifting),
    "load_cases/engine": Shown("Which load case governs a connecting rod, and by which mode?", governing),
    "free_motion/pendulum": Shown("How long does a bar take that swings from horizontal?", swinging),
    "free_motion/driven_pendulum": Shown("Does a pendulum repeat its motion under an alternating torque?", parting),
    "free_motion/door_closer": Shown("When does a door shut, and how hard?", shutting),
    "free_motion/drop_hammer": Shown("How hard does a ram of 50 kg hit that drops by 1 m?", hammering),
    "free_motion/motor_start": Shown("How long does a motor take to bring a fan up to its speed?", starting),
    "free_motion/press_with_flywheel": Shown("How much does a stroke slow the flywheel of a press?", slowing),
    "free_motion/walking_legs": Shown("How evenly does a motor turn a pair of walking legs?", walking),
    "free_motion/wiper": Shown("Which torque does a wiper need whose blade rubs?", wiping),
    "free_motion/pick_and_place": Shown("How far does a slender arm swing on after its move?", residual),
}


def section(name: str, result: fm.Result, complete: fm.Result | None = None) -> str:
    """Write the part of the page about a demo.

    Parameters
    ----------
    name
        Its path within `demos`, without ending.
    result
        Its result.
    complete
        Its result with all effects that it calls for, where its own verdict warns.
    """
    lines = [
        f"## {result.stated.name[:1].upper()}{result.stated.name[1:]}",
        f'<img src="../demos/{name}.png" width="420" alt="{result.stated.name}">',
        f"*{SHOWN[name].question}* Scene: `demos/{name}.toml`",
        f"{SHOWN[name].answer(result)} {usable(result)}",
    ]
    if complete is not None:
        lines[-1] += f" {of('theory', result).text.removesuffix(advice(result)).strip()}"
        lines.append(f'With `effects = "auto"`: {SHOWN[name].answer(complete)} {usable(complete)}')
    return "\n\n".join(lines) + "\n"


def usable(result: fm.Result) -> str:
    """Say whether the numbers can be used."""
    if result.scene.members():
        return verdict(judgements(result))[1]
    if "not_estimated" in result.data.attrs:
        return f"The links are rigid. Not estimated is {result.data.attrs['not_estimated']}."
    if "lyapunov_exponent" in result.data:
        return "The links are rigid. Only statistics of such a motion can be compared, so that no error is estimated."
    wrong = float(result.data.attrs["joint_force_error_estimate"])
    size = share(wrong)
    bound = "" if size.startswith("less") else "at most "
    led = ", and the drive leads them" * (not result.data.attrs["time_steps"])
    return f"The links are rigid{led}. Joint forces are off by {bound}{size}, by estimate."


def results(name: str) -> tuple[fm.Result, fm.Result | None]:
    """Analyse a demo, and where its verdict warns, once more with all effects that it calls for.

    Parameters
    ----------
    name
        Its path within `demos`, without ending.
    """
    scene = fm.load(DEMOS / f"{name}.toml")
    result = fm.analyse(scene)
    warns = bool(scene.members()) and verdict(judgements(result))[0] in ("bad", "warn")
    return result, fm.analyse(scene.changed(effects="auto")) if warns else None


def draw(name: str, result: fm.Result) -> None:
    """Draw a demo at its largest strain; one of rigid links by its motion.

    Parameters
    ----------
    name
        Its path within `demos`, without ending.
    result
        Its result.
    """
    if result.scene.members():
        fm.animate(result, DEMOS / f"{name}.png", size=SIZE)
    else:
        free = "freedom_place" in result.data and SHOWN[name].answer is not rattling
        figure = (poincare_figure if SHOWN[name].answer is parting else freedom_figure if free else force_figure)(
            result
        )
        figure.savefig(DEMOS / f"{name}.png", dpi=110)


def main(names: list[str]) -> None:
    """Write sections and pictures of some demos, or of all, and keep what else is on the page.

    Parameters
    ----------
    names
        Their paths within `demos`, without ending; none for all.
    """
    head, *kept = PAGE.read_text().split("\n## ")
    parts = {name: text for name in SHOWN for text in kept if f"`demos/{name}.toml`" in text}
    for name in names or SHOWN:
        result, complete = results(name)
        parts[name] = section(name, result, complete).removeprefix("## ")
        if name != MADE_BY_SWEEP:
            draw(name, result)
    PAGE.write_text("\n## ".join([head, *(parts[name] for name in SHOWN if name in parts)]))


if __name__ == "__main__":
    main(sys.argv[1:])
