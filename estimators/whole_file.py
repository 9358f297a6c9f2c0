"""Files that appear whole under their name or not at all; a device, a pipe or the end of a link is written through."""

from __future__ import annotations

import errno
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any


def write_whole(path: Path, content: bytes) -> None:
    """Makes missing folders. OSError that names `path` where it cannot be written; an older file then stays as it
    was."""
    try:
        target = path.resolve()
        if target.exists() and not target.is_file() and not target.is_dir():
            target.write_bytes(content)
            return
        target.parent.mkdir(parents=True, exist_ok=True)
        part = target.with_name(f".{target.name}.{os.getpid()}.part")
        try:
            part.write_bytes(content)
            part.replace(target)
        finally:
            part.unlink(missing_ok=True)
    except OSError as error:
        raise OSError(error.errno, error.strerror or str(error), str(path)) from None


def write_json(path: Path, content: Mapping[str, Any]) -> None:
    """JSON values, as `write_whole`. ValueError for a number that JSON does not have (nan, infinite)."""
    write_whole(path, (json.dumps(content, indent=1, allow_nan=False) + "\n").encode())


def check_writable(path: Path) -> None:
    """OSError for a file that `write_whole` could not write: better told before long work than after it."""
    if not path.name or path.is_dir():
        raise OSError(errno.EISDIR, "is a folder, want a file name", str(path))
    if path.exists() and not path.is_file():
        return
    try:
        target = path.resolve()
        target.parent.mkdir(parents=True, exist_ok=True)
        part = target.with_name(f".{target.name}.{os.getpid()}.part")
        part.touch()
        part.unlink()
    except OSError as error:
        raise OSError(error.errno, error.strerror or str(error), str(path)) from None
