"""The table of the page that says how safe every member is, by every mode, and what was assumed."""

from __future__ import annotations

from fenics_mech.safety import KEYS, Check, judge
from fenics_mech.views.page.html import EMPTY, Html, table, tag
from fenics_mech.views.reading import Reading
from fenics_mech.views.safety_words import acting, factor


def safety(reading: Reading) -> Html:
    """Tabulate factors of safety by member and mode, the least safe member first."""
    found = judge(reading.result)
    known = {check.mode for checks in found.checks.values() for check in checks if check.known}
    modes, rows = [mode for mode in KEYS if mode in known], []
    for member, checks in found.checks.items():
        by_mode = {check.mode: check for check in checks}
        rows.append(tag("tr", tag("th", member, class_="t"), *(_cell(by_mode[mode], reading) for mode in modes)))
    lead = (
        "Factors of safety over the cycle, and below them what acts of what is borne. Red: less than is wanted. "
        "Hatched: it rests on an assumed grade, pin or limit, and does not decide."
    )
    lead += " Of several load cases it is that of the worst, which is named." if reading.result.cases else ""
    lists = [_list("Taken as, where the scene does not say", found.assumed), _list("Not judged", found.missing)]
    body = table(["member", *(f"{mode}<" for mode in modes)], rows, class_="safety")
    return tag("section", tag("h2", "Safety"), tag("p", lead, class_="lead"), body, *lists, class_="card")


def _cell(check: Check, reading: Reading) -> Html:
    """Write a factor of safety, and what acts of what is borne."""
    if not check.known:
        return tag("td", "\N{EN DASH}", class_="t none", title=check.missing, data_mode=check.mode)
    kind = "bad" if check.share < 1 else "good"
    assumed = "" if check.decides else " assumed"
    return tag(
        "td",
        tag("b", factor(check)),
        tag("span", acting(check, reading.units)),
        tag("small", f"wanted {check.wanted:g}"),
        class_=f"t {kind}{assumed}",
        data_mode=check.mode,
    )


def _list(title: str, texts: tuple[str, ...]) -> Html:
    if not texts:
        return EMPTY
    return tag("p", tag("b", f"{title}: "), "; ".join(texts), ".", class_="hint")
