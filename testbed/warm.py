"""python -m testbed.warm: compiles every kernel of a drive into the disk cache, so that the first drive starts at once.

Short drives over each kind of road that has kernels of its own, with sensors, estimators and recording, and one
roughness index. About half a minute when something has changed, two seconds when nothing has.
"""

from __future__ import annotations

import hashlib
import sys
import tempfile
import time
from pathlib import Path

import numba
import numpy as np

import estimators.compiled  # noqa: F401  names the cache folder
from estimators.itpms.monitor import judge_nothing
from estimators.registry import registered
from testbed.drive import drive
from testbed.roads.iri import iri
from testbed.roads.road import ISO_SPACING
from testbed.scenario import Scenario

DURATION = 3.2  # s: more than one stretch, and a second of wheel speed for the vibration analysis


def warm() -> None:
    """Runs what there is to compile; leaves nothing but the cache."""
    with tempfile.TemporaryDirectory() as folder:
        profile = Path(folder) / "profile.txt"
        profile.write_text("".join(f"{0.25 * k} {0.001 * (k % 3)}\n" for k in range(40)))
        drive(Scenario(road="A:20,D:300", duration=DURATION), Path(folder) / "warm.rrd", tuple(registered()))
        drive(Scenario(road=str(profile), duration=DURATION), None, [])
        steered = Scenario(road=str(profile), duration=DURATION, active_steering=True)
        drive(steered, None, ["steering_actuator"])
    iri(np.zeros(round(30.0 / ISO_SPACING)), ISO_SPACING)
    judge_nothing()


def warm_once() -> None:
    """The same, unless it was done with these sources: before several processes begin, so that one of them compiles
    and not each."""
    place = hashlib.sha256(str(Path(__file__).resolve()).encode()).hexdigest()[:8]  # kernels are cached by their file's
    done = Path(numba.config.CACHE_DIR) / f"warm-{place}"
    if numba.config.CACHE_DIR and not done.is_file():
        warm()
        done.touch()


def main() -> int:
    """Exit status 0."""
    start = time.perf_counter()
    print("compiling kernels (about half a minute after a change of the code) ...", flush=True)
    warm()
    print(f"ready after {time.perf_counter() - start:.0f} s")
    return 0


if __name__ == "__main__":
    sys.exit(main())
