"""The matrix as heat maps: sensors down, faults across; a cell that no monitor guards is grey and says so."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Colormap
from matplotlib.figure import Figure
from numpy.typing import NDArray

from testbed.study.fault_matrix import events
from testbed.study.fault_matrix.faults import KINDS, LONG, SENSORS, SHORT
from testbed.study.fault_matrix.matrix import Entry, matrix
from testbed.study.study import Row

WIDTH = 10.4  # inches
GREY, NONE, INK = "#d5d9df", "#ffffff", "#30353d"
NOBODY = "nobody"
SIZE = (WIDTH, 5.4)
Cells = Mapping[str, Entry]


def figures(rows: Sequence[Row]) -> dict[str, Figure]:
    """By file name."""
    cells = matrix(rows)
    drawn = {}
    if cells:
        drawn = {
            "delay": _map(cells, _delay_shown, lambda e: e.delay(0.5).value, "YlOrBr", float(SHORT),
                          "delay to the accusation of the right sensor, p50 / p95 (s)"),
            "missed": _map(cells, lambda e: f"{100 * e.missed / e.trials:.0f}", lambda e: 100 * e.missed / e.trials,
                           "YlOrBr", 100.0, f"missed within {SHORT} s ({LONG} s: tyre sensors) (%)"),
            "isolation": _map(cells, _isolated_shown, _isolated, "YlGn", 100.0,
                              "of those in which anybody is accused: the right sensor first (%)"),
            "false-accusations": _map(cells, lambda e: f"{100 * e.falsely / e.trials:.0f}",
                                      lambda e: 100 * e.falsely / e.trials, "OrRd", 100.0,
                                      "an alarm accuses another sensor, or a sound tyre (%)", unguarded=False),
        }  # fmt: skip
    happened = [row for row in rows if "event" in row]
    return drawn | ({"events": _events(happened)} if happened else {})


def _delay_shown(entry: Entry) -> str:
    late = entry.delay(0.95).value
    return f"{_seconds(entry.delay(0.5).value)}/{_seconds(late)}"


def _seconds(value: float) -> str:
    return "–" if not np.isfinite(value) else f"{value:.1f}" if value < 9.95 else f"{value:.0f}"


def _isolated(entry: Entry) -> float:
    return 100.0 * entry.isolated / entry.accused if entry.accused else 0.0


def _isolated_shown(entry: Entry) -> str:
    return f"{_isolated(entry):.0f}"


def _map(
    cells: Cells, shown: Callable[[Entry], str], value: Callable[[Entry], float], colours: str, most: float,
    title: str, unguarded: bool = True,
) -> Figure:  # fmt: skip
    """unguarded: whether a cell whose sensor nobody ever accused has no figure."""
    figure = Figure(figsize=SIZE, layout="constrained")
    axes = figure.subplots()
    table = np.full((len(SENSORS), len(KINDS)), np.nan)
    texts: list[tuple[int, int, str, bool]] = []
    for i, sensor in enumerate(SENSORS):
        for j, kind in enumerate(KINDS):
            entry = cells.get(f"{sensor.name.format(wheel='WHEEL')}={kind}")
            if entry is None:
                continue
            if unguarded and not entry.guarded:
                _block(axes, j, i)
                texts.append((i, j, NOBODY, False))
                continue
            table[i, j] = min(value(entry), most) if np.isfinite(value(entry)) else most
            texts.append((i, j, shown(entry), True))
    _draw(figure, axes, table, texts, colours, most)
    axes.set_xticks(range(len(KINDS)), KINDS, fontsize=8.0, rotation=20.0, ha="left")
    axes.set_yticks(range(len(SENSORS)), [s.name.format(wheel="WHEEL") for s in SENSORS])
    axes.set_title(title, loc="left")
    return figure


def _block(axes: Axes, x: int, y: int) -> None:
    axes.add_patch(_rectangle(x, y))


def _rectangle(x: int, y: int) -> Any:
    from matplotlib.patches import Rectangle

    return Rectangle((x - 0.5, y - 0.5), 1.0, 1.0, facecolor=GREY, edgecolor="white")


def _draw(
    figure: Figure,
    axes: Axes,
    table: NDArray[np.float64],
    texts: Sequence[tuple[int, int, str, bool]],
    colours: str,
    most: float,
) -> None:
    image = axes.imshow(table, aspect="auto", cmap=colours, vmin=0.0, vmax=1.25 * most)
    map_: Colormap = image.get_cmap()
    for i, j, text, known in texts:
        dark = known and sum(map_(table[i, j] / (1.25 * most))[:3]) < 1.5
        axes.text(j, i, text, ha="center", va="center", fontsize=7.5, color="white" if dark else INK,
                  style="normal" if known else "italic")  # fmt: skip
    axes.grid(False)
    axes.tick_params(length=0)
    axes.xaxis.tick_top()
    for side in axes.spines.values():
        side.set_visible(False)
    axes.set_xticks(np.arange(-0.5, table.shape[1]), minor=True)
    axes.set_yticks(np.arange(-0.5, table.shape[0]), minor=True)
    axes.grid(which="minor", color="white", linewidth=1.2)
    axes.tick_params(which="minor", length=0)
    figure.colorbar(image, ax=axes, fraction=0.025, boundaries=np.linspace(0.0, most, 64), ticks=[0.0, most])


def _events(rows: Sequence[Row]) -> Figure:
    """Events down, monitors across: share of drives in which the monitor accuses rightly + wrongly."""
    monitors = sorted({by for row in rows for _, by, _ in row["accused"]}) or ["none"]
    figure = Figure(figsize=(WIDTH, 2.6), layout="constrained")
    axes = figure.subplots()
    table, texts = np.full((len(events.EVENTS), len(monitors)), np.nan), []
    for i, event in enumerate(events.EVENTS):
        of = [row for row in rows if row["event"] == event.name]
        for j, monitor in enumerate(monitors if of else ()):
            said = [[right for _, by, right in row["accused"] if by == monitor] for row in of]
            right, wrong = sum(any(s) for s in said), sum(not all(s) for s in said)
            table[i, j] = 100.0 * wrong / len(of)
            texts.append((i, j, f"{right} right, {wrong} wrong of {len(of)}" if right or wrong else "silent", True))
    _draw(figure, axes, table, texts, "OrRd", 100.0)
    axes.set_xticks(range(len(monitors)), monitors)
    axes.set_yticks(range(len(events.EVENTS)), [event.name for event in events.EVENTS])
    axes.set_title("no sensor is faulty: drives in which somebody is accused rightly or wrongly (colour: wrongly, %)",
                   loc="left")  # fmt: skip
    return figure
