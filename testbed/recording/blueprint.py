"""The layout of a drive's recording: everything at a glance, nothing to click.

Left: the car on its road, the camera tied to the chassis; below it alarms and modes as lanes and as a log. Right: plots
over the last twelve seconds, their time axes linked: first one a wheel with the truth of what is estimated, the
estimate and its band, then the physics. Only signals that the recording holds are asked for, and a plot without any is
left out. Everything is in raw SI; each plot's title has its unit.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import rerun.blueprint as rrb

from estimators.drive_log import HIDDEN, WHEELS
from estimators.readers.rrd_chunks import TIMELINE, entity_path
from testbed.recording.series import wheel_of

_BEFORE, _AFTER = 8.0, 4.0  # [s] of the plots' window on either side of the cursor
_EYE = (-7.5, -5.5, 3.0)  # [m] from the chassis: behind, right, above; the viewer keeps it so while it follows
_TARGET = (0.0, 0.0, 0.0)  # [m] from the chassis
_SKY = (44, 52, 64)
Ranges = Mapping[str, tuple[float, float]]  # lowest and highest, by name
_WHEEL = f"(?:{'|'.join(WHEELS)})"


@dataclass(frozen=True)
class Plot:
    """A plot: title, unit, and the names it takes (a pattern)."""

    title: str
    unit: str
    names: str


# of a wheel, the first that is estimated: what is inferred before what is measured
QUANTITIES = ("relative_pressure_change", "pressure", "stiffness", "relative_radius_change")
PLOTS = (
    Plot("Tyre pressure", "Pa", rf"truth/{_WHEEL}/pressure"),
    Plot("Rolling radius", "m", rf"truth/{_WHEEL}/rolling_radius"),
    Plot("Wheel load", "N", rf"truth/{_WHEEL}/load"),
    Plot("Hub acceleration", "m/s²", rf"hub/{_WHEEL}/accel_z"),
    Plot("Speed", "m/s", r"truth/chassis/speed"),
    Plot("Wheel speed", "rad/s", rf"wheel/{_WHEEL}/speed"),
)
_MEASURED = {"Tyre pressure": rf"tyre/{_WHEEL}/pressure"}  # where there is no truth: a real car's log
SOUND = "truth/sound/"  # a sensor before its fault
_AT_A_GLANCE = 8  # plots
_LEGEND_LINES = 4  # a longer legend would hide the plot; every line still has its name under the mouse


def drive_layout(
    kinds: Mapping[str, tuple[str, str]],
    bands: Ranges,
    reach: Ranges,
    drawn: Iterable[str],
    starts: Mapping[str, tuple[float, float, float]],
) -> rrb.Blueprint:
    """The blueprint for a recording.

    kinds: name -> (unit, kind) of every signal. bands: estimates that have one -> where it usually lies, low to high.
    reach: truths -> lowest and highest value. drawn: entities with a shape.
    starts: where each moving body is at first [m]; the camera follows the one named chassis, or else the first.
    """
    plots = _plots(kinds, bands, reach)
    left = _left(kinds, set(drawn), starts)
    parts = [part for part in (left, _right(plots)) if part is not None]
    return rrb.Blueprint(
        rrb.Horizontal(*parts, column_shares=[5, 6][: len(parts)]),
        rrb.BlueprintPanel(state="hidden"),
        rrb.SelectionPanel(state="hidden"),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE, play_state="playing"),
        auto_views=False,
        auto_layout=False,
    )


def _right(plots: list[rrb.TimeSeriesView]) -> rrb.Container | None:
    """The first plots in a grid; more than it holds wait in a second tab."""
    grids = [plots[:_AT_A_GLANCE], plots[_AT_A_GLANCE:]]
    columns = 2 if len(plots) > 3 else 1
    tabs = [
        rrb.Grid(*grid, grid_columns=columns, name=name)
        for grid, name in zip(grids, ("Tyres and car", "More estimates"), strict=True)
        if grid
    ]
    return rrb.Tabs(*tabs, active_tab=0) if len(tabs) > 1 else tabs[0] if tabs else None


def _plots(kinds: Mapping[str, tuple[str, str]], bands: Ranges, reach: Ranges) -> list[rrb.TimeSeriesView]:
    """The wheels' plots, the physics, then every other estimate."""
    numbers = {name: unit for name, (unit, kind) in kinds.items() if kind != "text"}
    estimated = [name for name in numbers if name.startswith("est/") and not name.endswith("/std")]
    first, taken = _of_wheels(numbers, estimated, bands, reach)
    plots = [
        _plot(f"{name.removeprefix(SOUND)}, sound and as it said [{unit or '-'}]", [name, sensor], bands, reach)
        for name, unit in numbers.items()
        if name.startswith(SOUND) and (sensor := name.removeprefix(SOUND)) in numbers
    ]
    for plot in PLOTS:
        names = [n for n in numbers if re.fullmatch(plot.names, n)]
        if not names and plot.title in _MEASURED:
            names = [n for n in numbers if re.fullmatch(_MEASURED[plot.title], n)]
        if names:
            plots.append(_plot(f"{plot.title} [{plot.unit}]", names, bands, reach))
    rest: dict[tuple[str, str], list[str]] = {}  # the same quantity of all wheels together
    for name in estimated:
        if name not in taken:
            quantity = _quantity(name) if wheel_of(name) else " ".join(name.split("/")[1:])
            rest.setdefault((quantity.replace("_", " "), numbers[name]), []).append(name)
    more = [_plot(f"Estimated {q} [{unit or '-'}] ±σ", names, bands, reach) for (q, unit), names in rest.items()]
    return first + plots + more


def _quantity(name: str) -> str:
    return name.rsplit("/", 1)[-1]


def _of_wheels(
    numbers: Mapping[str, str], estimated: Sequence[str], bands: Ranges, reach: Ranges
) -> tuple[list[rrb.TimeSeriesView], set[str]]:
    """A plot a wheel of the first of QUANTITIES that is estimated: truth, estimates of every method and their bands;
    and the estimates shown."""
    for quantity in QUANTITIES:
        names = [n for n in estimated if _quantity(n) == quantity and wheel_of(n)]
        if names:
            break
    else:
        return [], set()
    plots = []
    for wheel in WHEELS:
        said = [n for n in names if wheel_of(n) == wheel]
        truth = [n for n in numbers if n == f"truth/{wheel}/{quantity}"]
        title = f"{wheel} {quantity.replace('_', ' ')} [{numbers[names[0]] or '-'}]"
        if said:
            plots.append(_plot(f"{title} ±σ", truth + said, bands, reach))
    return plots, set(names)


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


def _left(
    kinds: Mapping[str, tuple[str, str]], drawn: set[str], starts: Mapping[str, tuple[float, float, float]]
) -> rrb.Vertical | None:
    texts = [name for name, (_, kind) in kinds.items() if kind == "text"]
    views: list[rrb.View] = []
    shares: list[float] = []
    if drawn:
        views.append(_scene(drawn, starts))
        shares.append(5)
    if texts:
        lanes = [entity_path(name) for name in texts if not name.endswith("/flags")]  # a flag is of one moment
        if lanes:
            views.append(rrb.StateTimelineView(origin="/", contents=lanes, name="Alarms and modes"))
            shares.append(1.2)
        log = [entity_path(name) for name in texts if not name.startswith(HIDDEN)]
        views.append(_events(log or lanes))
        shares.append(1.5)
    return rrb.Vertical(*views, row_shares=shares) if views else None


def _events(contents: list[str]) -> rrb.TextLogView:
    columns = rrb.TextLogColumns(timeline_columns=[TIMELINE], text_log_columns=["entitypath", "body"])
    return rrb.TextLogView(origin="/", contents=contents, name="Events", columns=columns)


def _scene(drawn: set[str], starts: Mapping[str, tuple[float, float, float]]) -> rrb.Spatial3DView:
    moving = [entity for entity in starts if entity in drawn]  # a body without a shape cannot be followed
    chassis = next((entity for entity in moving if "chassis" in entity), moving[0] if moving else None)
    start = starts[chassis] if chassis else (0.0, 0.0, 0.0)
    eye = rrb.EyeControls3D(
        kind=rrb.Eye3DKind.Orbital,
        position=[s + e for s, e in zip(start, _EYE, strict=True)],
        look_target=[s + t for s, t in zip(start, _TARGET, strict=True)],
        eye_up=(0.0, 0.0, 1.0),
        tracking_entity=entity_path(chassis) if chassis else None,
    )
    roots = sorted({"/" + entity.split("/")[0] for entity in drawn})
    return rrb.Spatial3DView(
        origin="/",
        contents=[f"{root}/**" for root in roots],
        name="Car and road",
        eye_controls=eye,
        background=rrb.Background(kind=rrb.BackgroundKind.SolidColor, color=_SKY),
        line_grid=False,
    )
