"""A digest of all that decides the numbers of a drive: this project's sources and data, and the versions below them.

What only reads finished rows (judgement, report, command line) and what only measures speed is left out, so a change of
a page does not cost the drives.
"""

from __future__ import annotations

import hashlib
from functools import cache
from importlib.metadata import version
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("estimators", "models", "testbed")
BELOW = ("mujoco", "numpy", "scipy", "numba", "filterpy")
KINDS = (".py", ".toml")
AFTERWARDS = (
    "estimators/scores/",
    "testbed/bench/",
    "testbed/campaign/__main__",
    "testbed/campaign/arguments",
    "testbed/campaign/estimate",
    "testbed/campaign/examples/",
    "testbed/campaign/judge",
    "testbed/campaign/progress",
    "testbed/campaign/replay",
    "testbed/campaign/report",
)


@cache
def code_version() -> str:
    """16 hexadecimal digits; another digest means that finished drives are not comparable with new ones."""
    digest = hashlib.sha256("".join(f"{name} {version(name)}\n" for name in BELOW).encode())
    sources = (f for package in PACKAGES for f in (ROOT / package).rglob("*") if f.suffix in KINDS)
    for name, source in sorted((f.relative_to(ROOT).as_posix(), f) for f in sources):
        if not name.startswith(AFTERWARDS):
            digest.update(name.encode() + source.read_bytes())
    return digest.hexdigest()[:16]
