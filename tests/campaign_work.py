"""Works that stand in for drives in the tests of the campaign engine: a task's row in no time, or what can go wrong."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path
from typing import Any


def square(task: dict[str, Any]) -> dict[str, Any]:
    """The row of a sound task; `note` names a file that counts how often it was done."""
    if "note" in task:
        with Path(task["note"]).open("a") as note:
            note.write(f"{task['x']}\n")
    return {"x": task["x"], "square": task["x"] ** 2, "series": [0.5 * task["x"], float("nan")]}


def refusing(task: dict[str, Any]) -> dict[str, Any]:
    """Fails on odd numbers, in two lines."""
    if task["x"] % 2:
        raise ValueError(f"{task['x']} is odd\nvalid: even")
    return square(task)


def dying_once(task: dict[str, Any]) -> dict[str, Any]:
    """Kills its own process on the task that says so, the first time."""
    flag = Path(task["flag"])
    if task["x"] == 2 and not flag.exists():
        flag.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return square(task)


def dying(task: dict[str, Any]) -> dict[str, Any]:
    """Kills its own process on the tasks that say so, every time."""
    if task["deadly"]:
        os.kill(os.getpid(), signal.SIGKILL)
    return square(task)


def large(task: dict[str, Any]) -> dict[str, Any]:
    """A row that takes a megabyte from x = 2 on, and later than the others."""
    if task["x"] < 2:
        return square(task)
    time.sleep(0.5)
    return square(task) | {"bulk": os.urandom(500_000).hex()}
