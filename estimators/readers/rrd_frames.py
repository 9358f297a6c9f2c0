"""How much of an .rrd file is whole: a killed process may leave its last message torn.

Layout (Rerun's RRF2): 12 bytes of header, then messages of 16 bytes (kind, payload length, both little-endian uint64)
and a payload. Kind 0 ends the stream; its payload is the footer that only a finished recording has.
"""

from __future__ import annotations

import struct
from pathlib import Path

_MAGIC = b"RRF2"
_HEADER = 12  # bytes: magic, version, encoding
_FRAME = struct.Struct("<QQ")
_END = 0
_TAIL = 32  # bytes after the last message of a finished file: where the footer is


def whole_length(path: Path) -> tuple[int, bool]:
    """Bytes up to the end of the last whole message, and whether the file is finished (it has its footer).

    Raises ValueError with the path if the file does not start as a recording does or holds no whole message.
    """
    size = path.stat().st_size
    with path.open("rb") as file:
        if file.read(_HEADER)[: len(_MAGIC)] != _MAGIC or size < _HEADER:
            raise ValueError(f"{path}: not a Rerun recording (.rrd)")
        position = _HEADER
        while position + _FRAME.size <= size:
            file.seek(position)
            kind, length = _FRAME.unpack(file.read(_FRAME.size))
            after = position + _FRAME.size + length
            if after > size:
                break
            if kind == _END:
                return position, size >= after + _TAIL
            position = after
    if position == _HEADER:
        raise ValueError(f"{path}: the recording is cut short before its first sample")
    return position, False
