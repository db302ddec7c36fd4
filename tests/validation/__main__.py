"""`python -m tests.validation`: compare this installation with the dissertation and with a hand-coded model."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from rich import box
from rich.markup import escape
from rich.table import Table

from fenics_mech._console import out, progress_bar
from tests.validation.check import CHECKS, Finding


def check_table(findings: Sequence[Finding]) -> Table:
    """Tabulate comparisons."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, title="Comparisons", title_justify="left", title_style="bold")
    table.add_column("what")
    table.add_column("found", justify="right", no_wrap=True)
    table.add_column("needed", justify="right", no_wrap=True)
    table.add_column("", no_wrap=True)
    for finding in findings:
        verdict = "[green]holds[/]" if finding.holds else "[bold red]FAILS[/]"
        table.add_row(escape(finding.what), escape(finding.measured), escape(finding.bound), verdict)
    return table


def main() -> int:
    """Print all comparisons, and give the exit code: 1 where one fails."""
    findings = []
    with progress_bar(len(CHECKS)) as step:
        for name, examine in CHECKS.items():
            step(name)
            findings += examine()
    out.print(check_table(findings))
    return int(not all(finding.holds for finding in findings))


if __name__ == "__main__":
    sys.exit(main())
