"""The layout of a drive's recording: everything at a glance, nothing to click.

Left: the car on its road, the camera tied to the chassis; below it alarms and modes as lanes and as a log. Right: plots
over the last twelve seconds in tabs (`plots`). Only signals that the recording holds are asked for.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import rerun.blueprint as rrb

from estimators.drive_log import HIDDEN
from estimators.readers.rrd_chunks import TIMELINE, entity_path
from testbed.recording.plots import Ranges, tabs_of_plots
from testbed.recording.series import VERDICT

_EYE = (-7.5, -5.5, 3.0)  # [m] from the chassis: behind, right, above; the viewer keeps it so while it follows
_TARGET = (0.0, 0.0, 0.0)  # [m] from the chassis
_SKY = (44, 52, 64)


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
    left = _left(kinds, set(drawn), starts)
    parts = [part for part in (left, _right(tabs_of_plots(kinds, bands, reach))) if part is not None]
    return rrb.Blueprint(
        rrb.Horizontal(*parts, column_shares=[5, 6][: len(parts)]),
        rrb.BlueprintPanel(state="hidden"),
        rrb.SelectionPanel(state="hidden"),
        rrb.TimePanel(state="collapsed", timeline=TIMELINE, play_state="playing"),
        auto_views=False,
        auto_layout=False,
    )


def _right(tabs: Mapping[str, list[rrb.TimeSeriesView]]) -> rrb.Container | None:
    """A grid a tab, the first in front."""
    grids = [rrb.Grid(*plots, grid_columns=2 if len(plots) > 3 else 1, name=name) for name, plots in tabs.items()]
    return rrb.Tabs(*grids, active_tab=0) if len(grids) > 1 else grids[0] if grids else None


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
        states = [name for name in texts if not name.endswith("/flags")]  # a flag is of one moment
        verdicts = [name for name in states if name.startswith(VERDICT)]
        lanes = [entity_path(name) for name in (*verdicts, *(n for n in states if n not in verdicts))]
        if lanes:
            views.append(rrb.StateTimelineView(origin="/", contents=lanes, name="Who is accused, alarms and modes"))
            shares.append(1.2 + 0.4 * min(len(verdicts), 6))
        log = [entity_path(name) for name in texts if not name.startswith((HIDDEN, VERDICT))]
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
