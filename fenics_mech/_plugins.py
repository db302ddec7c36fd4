"""What other packages add to the program: objects behind entry points, found by group and name.

Only packages that are installed are asked, never the current folder: a scene may lie in a folder from a stranger. A
scene names a plugin, and cannot say which code that is.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, wraps
from importlib.metadata import Distribution, EntryPoint, distributions
from pathlib import Path
from typing import Any

from fenics_mech.errors import MechanismError


@dataclass(frozen=True)
class Plugin:
    """An object of another package."""

    name: str  # its name, as scenes state it
    package: str  # the package that it comes with
    entry: EntryPoint

    def __str__(self) -> str:
        return f"the plugin {self.name!r} of the package {self.package}"

    def load(self, kind: type) -> Any:
        """Import it; raise `MechanismError`, with its name, where that fails or gives another kind of object."""
        try:
            found = self.entry.load()
        except Exception as error:  # of a stranger's module: anything
            raise self.failed("cannot be loaded", error) from error
        if not (isinstance(found, kind) or (isinstance(found, type) and issubclass(found, kind))):
            raise self.refused(f"gives {type(found).__name__} where {kind.__name__} is expected")
        return found

    def refused(self, why: str) -> MechanismError:
        """Give the error that says why it cannot be taken, and what to do."""
        return MechanismError(f"{self} {why}. Correct it, or uninstall the package")

    def blamed(self, work: Callable[..., Any]) -> Callable[..., Any]:
        """Give a function of the plugin whose errors name it; errors of the program itself stay as they are."""

        @wraps(work)
        def called(*arguments: Any, **options: Any) -> Any:
            try:
                return work(*arguments, **options)
            except MechanismError:
                raise
            except Exception as error:
                raise self.failed(f"failed in {work.__name__}", error) from error

        return called

    def failed(self, how: str, error: Exception) -> MechanismError:
        """Give the error that says how it failed, and by which exception."""
        return MechanismError(f"{self} {how}: {type(error).__name__}: {error}")


@cache
def plugins(group: str) -> tuple[Plugin, ...]:
    """Give the plugins of a group such as "effects", by name; none of them is imported yet."""
    found: dict[str, Plugin] = {}
    trusted = [folder for folder in sys.path if folder and Path(folder).absolute() != Path.cwd()]
    for package in distributions(path=trusted):
        for entry in _entries(package, f"fenics_mech.{group}"):
            plugin = Plugin(entry.name, package.metadata["Name"], entry)
            other = found.setdefault(entry.name, plugin)
            if other.entry != entry:
                raise plugin.refused(f"has the name of {other}")
    return tuple(found[name] for name in sorted(found))


def _entries(package: Distribution, group: str) -> list[EntryPoint]:
    text = package.read_text("entry_points.txt")
    return [entry for entry in package.entry_points if entry.group == group] if text and group in text else []
