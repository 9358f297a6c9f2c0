"""Which plots a recording has, by tab: what is estimated of each wheel beside its truth, the physics, and the rest.

Everything is in raw SI; each plot's title has its unit. Time axes are linked, the window moves with the cursor.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import rerun.blueprint as rrb

from estimators.drive_log import WHEELS
from estimators.readers.rrd_chunks import TIMELINE, entity_path
from testbed.recording.series import share_of, wheel_of

_BEFORE, _AFTER = 8.0, 4.0  # [s] of the plots' window on either side of the cursor
Ranges = Mapping[str, tuple[float, float]]  # lowest and highest, by name
_WHEEL = f"(?:{'|'.join(WHEELS)})"
SOUND = "truth/sound/"  # a sensor before its fault
_PER_TAB = 9
_LEGEND_LINES = 4  # a longer legend would hide the plot; every line still has its name under the mouse


@dataclass(frozen=True)
class Plot:
    """A plot: title, unit, and the names it takes (a pattern)."""

    title: str
    unit: str
    names: str


# of each wheel, with its truth, every method's estimate and its band: tab, quantity, and what stands beside it there.
# The first one that a recording has shares its tab with the physics.
WHEEL_TABS = (
    ("Tyre pressure", "pressure", ()),
    ("Stiffness and road", "stiffness", ("road", "pressure_bound", "road_level", "coherence")),
    ("Pressure without a sensor", "relative_pressure_change", ("pressure_change", "low_probability", "voting_flag")),
    ("Radius", "relative_radius_change", ()),
)
FIRST, LAST = "Tyres and car", "More estimates"
PHYSICS = (
    Plot("Tyre pressure", "Pa", rf"truth/{_WHEEL}/pressure"),
    Plot("Rolling radius", "m", rf"truth/{_WHEEL}/rolling_radius"),
    Plot("Wheel load", "N", rf"truth/{_WHEEL}/load"),
    Plot("Hub acceleration", "m/s²", rf"hub/{_WHEEL}/accel_z"),
    Plot("Speed", "m/s", r"truth/chassis/speed"),
    Plot("Wheel speed", "rad/s", rf"wheel/{_WHEEL}/speed"),
)
STEERING_TAB, STEERING_MOTOR = "Steering", "steering/motor_angle"  # a tab of its own where there is such a motor
STEERING = (
    Plot("Steering wheel", "rad", r"steering/angle|truth/steering/wheel_angle"),
    Plot("Motor and its demand", "rad", r"steering/motor_(?:angle|demand)"),
    Plot("Pinion", "rad", r"(?:truth/)?steering/pinion_angle"),
    Plot("Road wheels", "rad", r"truth/steering/road_wheel_angle"),
    Plot("Motor speed", "rad/s", r"truth/steering/motor_speed"),
    Plot("Motor torque", "N m", r"truth/steering/motor_torque"),
)
_MEASURED = {"Tyre pressure": rf"tyre/{_WHEEL}/pressure"}  # where there is no truth: a real car's log
_ROOM = 8  # plots of the first tab; the physics takes what the wheels leave


def tabs_of_plots(
    kinds: Mapping[str, tuple[str, str]], bands: Ranges, reach: Ranges
) -> dict[str, list[rrb.TimeSeriesView]]:
    """Tab -> its plots; a plot or tab without any signal is left out. For the arguments see `drive_layout`."""
    numbers = {name: unit for name, (unit, kind) in kinds.items() if kind != "text"}
    rest = _estimated(numbers)
    tabs: dict[str, list[rrb.TimeSeriesView]] = {}
    for tab, quantity, companions in WHEEL_TABS:
        plots = _of_wheels(numbers, rest, quantity, bands, reach)
        if not plots:
            continue
        for key in [key for name in companions for key in rest if key[0] == name]:
            plots.append(_estimates(*key, rest.pop(key), numbers, bands, reach))
        if not tabs:
            plots += _physics(numbers, bands, reach, shown=quantity)
            tabs[FIRST] = plots[:_ROOM]
        else:
            tabs[tab] = plots
    if not tabs and (physics := _physics(numbers, bands, reach)):
        tabs[FIRST] = physics
    if STEERING_MOTOR in numbers:
        shown = [(plot, [n for n in numbers if re.fullmatch(plot.names, n)]) for plot in STEERING]
        tabs[STEERING_TAB] = [
            _plot(f"{plot.title} [{plot.unit}]", names, bands, reach) for plot, names in shown if names
        ]
    more = [_estimates(*key, names, numbers, bands, reach) for key, names in rest.items()]
    for start in range(0, len(more), _PER_TAB):
        number = f" {start // _PER_TAB + 1}" if len(more) > _PER_TAB else ""
        tabs[LAST + number] = more[start : start + _PER_TAB]
    return tabs


def _estimated(numbers: Mapping[str, str]) -> dict[tuple[str, str], list[str]]:
    """Estimates by quantity and unit: the same of all wheels together, shares of one whole together."""
    found: dict[tuple[str, str], list[str]] = {}
    for name, unit in numbers.items():
        if name.startswith("est/") and not name.endswith("/std"):
            if share_of(name):
                quantity = name.split("/")[-2]
            else:
                quantity = name.rsplit("/", 1)[-1] if wheel_of(name) else " ".join(name.split("/")[1:])
            found.setdefault((quantity, unit), []).append(name)
    return found


def _physics(numbers: Mapping[str, str], bands: Ranges, reach: Ranges, shown: str = "") -> list[rrb.TimeSeriesView]:
    """Faults of sensors first. shown: the quantity of the wheels that has its plots already."""
    plots = [
        _plot(f"{name.removeprefix(SOUND)}, sound and as it said [{unit or '-'}]", [name, sensor], bands, reach)
        for name, unit in numbers.items()
        if name.startswith(SOUND) and (sensor := name.removeprefix(SOUND)) in numbers
    ]
    for plot in PHYSICS:
        names = [n for n in numbers if re.fullmatch(plot.names, n)]
        if not names and plot.title in _MEASURED:
            names = [n for n in numbers if re.fullmatch(_MEASURED[plot.title], n)]
        if any(not name.endswith(f"/{shown}") for name in names):
            plots.append(_plot(f"{plot.title} [{plot.unit}]", names, bands, reach))
    return plots


def _of_wheels(
    numbers: Mapping[str, str], rest: dict[tuple[str, str], list[str]], quantity: str, bands: Ranges, reach: Ranges
) -> list[rrb.TimeSeriesView]:
    """A plot a wheel: truth, estimates of every method and their bands; what is shown is taken out of `rest`."""
    keys = [key for key in rest if key[0] == quantity and any(wheel_of(name) for name in rest[key])]
    names = [name for key in keys for name in rest.pop(key)]
    plots = []
    for wheel in WHEELS:
        said = [name for name in names if wheel_of(name) == wheel]
        truth = [name for name in numbers if name == f"truth/{wheel}/{quantity}"]
        if said:
            title = f"{wheel} {quantity.replace('_', ' ')} [{numbers[said[0]] or '-'}] ±σ"
            plots.append(_plot(title, truth + said, bands, reach))
    return plots


def _estimates(
    quantity: str, unit: str, names: Sequence[str], numbers: Mapping[str, str], bands: Ranges, reach: Ranges
) -> rrb.TimeSeriesView:
    """A plot of one quantity that is estimated; a bound beside the standard deviations that it bounds."""
    words = quantity.replace("_", " ")
    if quantity.endswith("_bound"):
        deviations = [std for name in names if (std := f"{name.removesuffix('_bound')}/std") in numbers]
        what = words.removesuffix(" bound")
        return _plot(f"Std of {what} and its bound [{unit or '-'}]", [*deviations, *names], {}, reach)
    if share_of(names[0]):
        return _plot(f"Probability of the {words}'s class, stacked [-]", names, bands, reach)
    return _plot(f"Estimated {words} [{unit or '-'}] ±σ", names, bands, reach)


def _plot(title: str, names: Sequence[str], bands: Ranges, reach: Ranges) -> rrb.TimeSeriesView:
    contents = [entity_path(f"{name}/band" if name in bands else name) for name in names]
    start = rrb.TimeRangeBoundary.cursor_relative(seconds=-_BEFORE)
    end = rrb.TimeRangeBoundary.cursor_relative(seconds=_AFTER)
    axis = None
    if any(name in bands for name in names):  # the viewer fits the lines only, and would cut the bands off
        usual = [both[name] for name in names for both in (bands, reach) if name in both]
        low, high = min(low for low, _ in usual), max(high for _, high in usual)
        axis = rrb.ScalarAxis(range=(low - 0.05 * (high - low), high + 0.05 * (high - low))) if high > low else None
    return rrb.TimeSeriesView(
        origin="/",
        contents=contents,
        name=title,
        axis_y=axis,
        time_ranges=rrb.VisibleTimeRange(TIMELINE, start=start, end=end),
        axis_x=rrb.archetypes.TimeAxis(link=rrb.components.LinkAxis.LinkToGlobal),
        plot_legend=rrb.PlotLegend(visible=len(names) <= _LEGEND_LINES, corner=rrb.Corner2D.LeftTop),
    )
