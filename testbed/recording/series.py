"""How a signal is drawn in a plot: its lines' names, with the unit, and their colours.

Wheels keep one colour everywhere; truth is the full colour, an estimate a paler one. The colours (after Okabe and Ito,
safe for the colour-blind) are readable on the viewer's dark and light grounds.
"""

from __future__ import annotations

import re

import rerun as rr

from estimators.drive_log import HIDDEN, WHEELS

WHEEL_COLOURS = {"fl": (38, 139, 210), "fr": (230, 140, 20), "rl": (20, 158, 115), "rr": (204, 84, 150)}
_AXIS_COLOURS = ((214, 80, 70), (60, 150, 60), (70, 110, 220))
_OTHER_COLOURS = ((120, 120, 130), (150, 105, 60), (110, 90, 180), (0, 140, 150), (180, 60, 60))
# ISO 8608 classes A to H, smooth to rough
_SHARE_COLOURS = (
    (60, 150, 70), (120, 175, 60), (190, 190, 60), (230, 165, 50),
    (225, 120, 50), (205, 80, 60), (165, 60, 90), (120, 60, 120),
)  # fmt: skip
_SHARE = re.compile(r"est/[^/]+/road/([A-H])")
_MEMBERS = {"attitude": ("roll", "pitch", "yaw")}
_TRUTH_WIDTH, _WIDTH = 1.8, 1.0  # [px]
ACCUSED, RED = "/accused", "red"  # entity under a signal's whose samples are drawn red; its kind in a layout
VERDICT = "est/verdict/"  # lanes of who is accused
_RED, _RED_WIDTH = (225, 30, 30, 150), 7.0
_PALE = 0.35  # share of grey in an estimate's colour


def wheel_of(name: str) -> str | None:
    """The wheel that a signal belongs to, from its path: `truth/fl/load`, `est/x/radius_fl`."""
    for part in name.replace("_", "/").split("/"):
        if part in WHEELS:
            return part
    return None


def share_of(name: str) -> str | None:
    """The class of `est/METHOD/road/CLASS`, a probability of several that sum to one."""
    found = _SHARE.fullmatch(name)
    return found[1] if found else None


def colours(name: str, width: int) -> list[tuple[int, int, int]]:
    """One colour for each of a signal's `width` lines."""
    if (share := share_of(name)) is not None:
        return [_SHARE_COLOURS["ABCDEFGH".index(share)]]
    wheel = wheel_of(name)
    if wheel is not None:
        chosen = [WHEEL_COLOURS[wheel]] * width
    elif width == len(WHEELS):
        chosen = list(WHEEL_COLOURS.values())
    elif width == 1:
        chosen = [_OTHER_COLOURS[sum(name.encode()) % len(_OTHER_COLOURS)]]
    else:
        chosen = [_AXIS_COLOURS[i % len(_AXIS_COLOURS)] for i in range(width)]
    return [_pale(colour) for colour in chosen] if name.startswith("est/") else chosen


def _pale(colour: tuple[int, int, int]) -> tuple[int, int, int]:
    red, green, blue = (round(c * (1.0 - _PALE) + 150 * _PALE) for c in colour)
    return red, green, blue


def labels(name: str, unit: str, width: int) -> list[str]:
    """Legend entries: the wheel or axis first, an estimate's method (or truth), the unit: `fl truth [Pa]`,
    `fl wheel_radius [m]`."""
    if (share := share_of(name)) is not None:
        return [f"road {share}"]
    wheel = wheel_of(name)
    parts = [part for part in name.split("/") if part != wheel]
    what = parts[-1]
    said = "" if wheel or width > 1 else what
    if name.startswith("est/"):
        said = "bound" if what.endswith("_bound") else " ".join(parts[1:2] + (["std"] if what == "std" else []))
    elif wheel and name.startswith(HIDDEN):
        said = "truth"
    ending = " ".join(filter(None, (said, f"[{unit}]" if unit else "")))
    if width == 1:
        return [" ".join(filter(None, (wheel, ending))) or what]
    members = _MEMBERS.get(what, ("x", "y", "z")) if width != len(WHEELS) else WHEELS
    return [f"{members[i] if i < len(members) else i} {ending}".rstrip() for i in range(width)]


def lines(name: str, unit: str, width: int) -> rr.SeriesLines:
    """The static style of a signal's lines."""
    thick = _TRUTH_WIDTH if name.startswith(HIDDEN) else _WIDTH
    return rr.SeriesLines(colors=colours(name, width), widths=[thick] * width, names=labels(name, unit, width))


def band(name: str, unit: str, width: int) -> rr.Measurements:
    """The static style of an estimate drawn with its band of one standard deviation either side."""
    return rr.Measurements.from_fields(
        colors=colours(name, width),
        widths=[_WIDTH] * width,
        names=labels(name, "", width),
        units=[unit] * width,
    )


def red(width: int) -> rr.SeriesLines:
    """The static style of the broad line that marks a sensor while it is accused."""
    return rr.SeriesLines(colors=[_RED] * width, widths=[_RED_WIDTH] * width, names=["accused"] * width)
