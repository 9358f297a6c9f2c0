"""`compiled` and `inlined`: numba's njit with a disk cache that can never be stale.

numba keys its cache by the time stamp of the one file that holds a function, so a caller keeps an old copy of a callee,
or of a constant, that was edited in another file. Here the cache folder's name is a digest of every source file that
compiled code can depend on: those that compile something, and all of this project that they import. An edit of one of
them starts a fresh cache; a second run of the same code compiles nothing. The GIL is released inside.
"""

from __future__ import annotations

import ast
import hashlib
import os
import shutil
import time
from pathlib import Path

import numba
from numba import njit

_ROOT = Path(__file__).resolve().parents[1]
_PACKAGES = ("estimators", "models", "testbed")
_KEPT_DAYS = 7.0  # caches of older sources go after this


def _imported(source: Path) -> set[Path]:
    """Files of this project that a source file imports."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(source.read_bytes())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
    places = [_ROOT.joinpath(*name.split(".")) for name in names]
    return {f for place in places for f in (place.with_suffix(".py"), place / "__init__.py") if f.is_file()}


def _digest() -> str:
    sources = [f for package in _PACKAGES for f in (_ROOT / package).rglob("*.py")]
    found: set[Path] = set()
    waiting = {f for f in sources if b"from estimators.compiled import" in f.read_bytes()}
    while waiting:
        found |= waiting
        waiting = set().union(*(_imported(f) for f in waiting)) - found
    digest = hashlib.sha256(numba.__version__.encode())
    for source in sorted(found):
        digest.update(str(source.relative_to(_ROOT)).encode() + source.read_bytes())
    return digest.hexdigest()[:16]


def _cache_folder() -> Path:
    home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "vehicle-testbed"
    folder = home / f"numba-{_digest()}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        os.utime(folder)
        for old in home.glob("numba-*"):
            if time.time() - old.stat().st_mtime > _KEPT_DAYS * 86400.0:
                shutil.rmtree(old, ignore_errors=True)
    except OSError:  # a home that cannot be written: numba then falls back to its own choice
        return Path(numba.config.CACHE_DIR or "")
    return folder


if not os.environ.get("NUMBA_CACHE_DIR"):
    numba.config.CACHE_DIR = str(_cache_folder())

compiled = njit(cache=True, nogil=True, error_model="numpy")
# for the parts of a hot loop: put into their caller by LLVM, which saves copying their parameter tuples at every call
inlined = njit(cache=True, nogil=True, error_model="numpy", forceinline=True)
