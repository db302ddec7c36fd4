"""Parts of the page: heading, verdict, key figures, and the frames that the script draws in."""

from __future__ import annotations

import numpy as np

from fenics_mech.views.judgements import headline, judgements, verdict
from fenics_mech.views.page.html import EMPTY, Html, join, tag
from fenics_mech.views.page.page_tables import frequencies
from fenics_mech.views.reading import Reading
from fenics_mech.views.words import sentence, short


def heading(reading: Reading) -> Html:
    """Name the machine and how it is driven, beside the buttons of the page.

    Parameters
    ----------
    reading
        The result.
    """
    buttons = (
        tag("button", "Print", id="print", type="button"),
        tag("button", "\N{CIRCLE WITH RIGHT HALF BLACK}", id="theme", type="button", aria_label="dark or light"),
    )
    name = tag("div", tag("h1", sentence(reading.scene.name)), tag("p", reading.driven()))
    return tag("header", name, tag("div", *buttons, class_="tools live"), class_="top")


def verdict_of(reading: Reading) -> Html:
    """Tell the peak, whether the numbers can be used, and why; the worst reason first, then warnings.

    Parameters
    ----------
    reading
        The result.
    """
    judged = judgements(reading.result)
    level, usable = verdict(judged)
    value, rest = headline(reading)
    reasons = [tag("li", tag("b", sentence(j.title)), tag("span", j.text), class_=j.level) for j in judged]
    warned = [tag("li", text) for text in reading.result.warnings]
    return tag(
        "section",
        tag("p", tag("strong", value), " ", rest, class_="headline"),
        tag("p", usable, class_="usable"),
        tag("ul", *reasons, class_="reasons"),
        tag("ul", *warned, class_="warned") if warned else EMPTY,
        class_=f"verdict {level}",
    )


def figures(reading: Reading) -> Html:
    """Show the numbers that a designer asks for first.

    Parameters
    ----------
    reading
        The result.
    """
    found = []
    peak = reading.peak(reading.bent, int(reading.bent.max(axis=(0, 2, 3)).argmax()))
    where = f"{reading.members[peak.i]}, {reading.place(peak)}, {reading.at(peak.k)}"
    found.append(_tile("largest deflection", float(reading.bent.max()), "mm", where))
    if reading.joints:
        k, n = map(int, np.unravel_index(reading.force.argmax(), reading.force.shape))
        found.append(
            _tile(
                "largest joint force",
                float(reading.force[k, n]),
                "N",
                f"joint {reading.joints[n]}, {reading.at(k)}",
            )
        )
    if reading.effort is not None:
        (name, unit), k = reading.effort_name, int(np.abs(reading.effort).argmax())
        span = (
            f"; from {short(reading.effort.min())} to {short(reading.effort.max())}" if len(reading.theta) > 1 else ""
        )
        found.append(_tile(f"largest {name}", float(reading.effort[k]), unit, f"{reading.at(k)}{span}"))
    if "frequency" in reading.result.data:
        frequency = reading.result.data["frequency"].to_numpy()
        least = float(frequency[frequency > 0].min(initial=np.inf))
        found.append(
            _tile("lowest natural frequency", least, "Hz", f"{short(least * reading.scene.period)} times the drive's")
        )
    return tag("section", *found, class_="tiles")


def _tile(name: str, value: float, unit: str, where: str) -> Html:
    return tag(
        "div", tag("span", name), tag("b", short(value), " ", tag("small", unit)), tag("i", where), class_="tile"
    )


def moving(reading: Reading) -> Html:
    """Give the frames of the drawing and of the curves at the peak's place, with what moves them.

    Parameters
    ----------
    reading
        The result.
    """
    said = tag("p", "The pictures need JavaScript. All numbers are in the tables below.")
    return join([tag("noscript", said), tag("div", _drawing(reading), _curves(reading), class_="stage live")])


def _drawing(reading: Reading) -> Html:
    """Make the frame of the drawing, and its controls."""
    what = "time" if reading.in_time else "drive angle"
    play = tag("button", "\N{BLACK RIGHT-POINTING TRIANGLE}", id="play", type="button", aria_label="play or stop")
    position = tag("label", f"{what} ", tag("output", id="told"), _slider("position", "any"), class_="grow")
    to_peak = tag("button", "peak", id="to-peak", type="button")
    size = tag("label", "deflection magnified ", tag("output", id="times"), _slider("magnify", "1"), class_="grow")
    arrows = tag("label", tag("input", type="checkbox", id="arrows"), " joint forces", class_="check")
    steps = tag("div", play, position, to_peak, class_="row") if len(reading.theta) > 1 else EMPTY
    legend = (
        "Each side of a member shows the stress of that side: ",
        tag("b", "blue compression", class_="comp"),
        ", ",
        tag("b", "red tension", class_="tens"),
        ". The ring is the place of the peak. Dashed: the rigid linkage.",
    )
    label = "The mechanism at the chosen position, its members coloured by stress"
    scale = (tag("span", id="least"), tag("canvas", id="scale", width=512, height=1), tag("span", id="most"))
    return tag(
        "section",
        tag("canvas", id="mechanism", role="img", aria_label=label),
        tag("div", *scale, class_="scale"),
        tag("p", *legend, class_="hint"),
        tag(
            "div", steps, tag("div", size, arrows, class_="row"), tag("p", id="hint", class_="hint"), class_="controls"
        ),
        class_="card drawing",
    )


def _slider(name: str, step: str) -> Html:
    return tag("input", id=name, type="range", min="0", step=step)


def _curves(reading: Reading) -> Html:
    """Make the frames of the curves, and the choice of member and unit."""
    members = [tag("option", name, value=i) for i, name in enumerate(reading.members)]
    units = [
        tag("option", text, value=value)
        for value, text in (("stress", "stress, MPa"), ("strain", "strain, \N{MICRO SIGN}m/m"))
    ]
    choice = (
        tag("label", "member ", tag("select", *members, id="member")),
        tag("label", "show ", tag("select", *units, id="unit")),
        tag("button", "CSV", id="csv", type="button") if len(reading.theta) > 1 else EMPTY,
    )
    moves = [*_plot("curve"), *_plot("map")] if len(reading.theta) > 1 else []
    return tag("section", tag("div", *choice, class_="pick"), *moves, *_plot("along"), class_="card")


def _plot(name: str) -> tuple[Html, Html]:
    """Make the frame of a plot, with its heading."""
    heads = (tag("b", id=f"{name}-title"), " ", tag("span", id=f"{name}-where"))
    return tag("h3", *heads), tag("div", id=name, class_="plot")


def dynamics(reading: Reading) -> Html:
    """Give the frames of torque, frequencies, spectrum and stability: of those that the result has.

    Parameters
    ----------
    reading
        The result.
    """
    data, cards = reading.result.data, []
    if reading.effort is not None and len(reading.theta) > 1:
        cards.append(_card(sentence(reading.effort_name[0]), "", "effort"))
    if "strain_amplitude" in data:
        cards.append(_card("Spectrum", "spectrum-where", "spectrum"))
    if "frequency" in data:
        cards.append(_card("Natural frequencies", "", "frequency", frequencies(reading)))
    if "multiplier" in data:
        said = (
            "Each point is what one cycle leaves of a small disturbance (a Floquet multiplier). "
            "Inside the circle it dies out."
        )
        cards.append(_card("Stability", "", "stability", tag("p", said, class_="hint")))
    return tag("div", *cards, class_="two") if cards else EMPTY


def _card(title: str, where: str, plot: str, more: Html = EMPTY) -> Html:
    head = tag("h2", title, " ", tag("small", id=where) if where else EMPTY)
    live_only = "" if more else " live"
    return tag("section", head, tag("div", id=plot, class_="plot live"), more, class_=f"card{live_only}")
