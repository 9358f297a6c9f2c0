"""The command lines of this package: bad arguments are one line, like every other bad input."""

from __future__ import annotations

import argparse
from typing import NoReturn


class Parser(argparse.ArgumentParser):
    """Bad arguments are a ValueError, like every other bad input."""

    def error(self, message: str) -> NoReturn:
        raise ValueError(f"{message}; --help lists the options")
