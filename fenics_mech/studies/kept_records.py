"""What is kept of points of sweeps and of trials: a file of each, with its numbers or the error that it ended with."""

from __future__ import annotations

import hashlib
import json
import logging
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from fenics_mech._files import write_whole
from fenics_mech.errors import MechanismError, SceneError

Record = dict[str, Any]
logger = logging.getLogger(__name__)
LOST = "LostProcess"  # error of what a process worked on that was ended from outside


def record_file(folder: Path, *parts: Any) -> Path:
    """Give the file of a record: its name is the hash of what it depends on."""
    text = json.dumps(parts, sort_keys=True)
    return folder / f"{hashlib.sha256(text.encode()).hexdigest()[:32]}.json"


def write_record(path: Path | None, record: Record) -> None:
    """Write a record, where it is to be kept."""
    if path is not None:
        text = json.dumps(record | {"message": str(MechanismError(record["message"]))})
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, lambda temporary: temporary.write_text(text))


def ended(work: Callable[[], Record]) -> Record:
    """Give what some work finds, or the error that it ended with, and the time that it took."""
    # After an error that the program does not know it is tried again by the next study.
    start = time.perf_counter()
    record: Record = {"error": "", "message": "", "again": False}
    try:
        record |= work()
    except (OSError, MemoryError) as error:  # of the computer, not of what is analysed
        raise MechanismError(f"the computer could not go on: {type(error).__name__}: {error}") from error
    except Exception as error:  # what a single analysis may end with is not known, and must not end the study
        if isinstance(error, SceneError) and error.place.startswith("study"):  # a name that no trial can give
            raise
        logger.info("an analysis failed: %s", error)
        record |= {"error": type(error).__name__, "message": str(error), "again": not isinstance(error, MechanismError)}
    return record | {"seconds": time.perf_counter() - start}


def lost(what: str) -> Record:
    """Give the record of what is tried again by the next study, as its process was ended from outside."""
    message = f"{what} was ended from outside: there may be too little memory"
    return {"error": LOST, "message": message, "again": True, "seconds": 0.0}
