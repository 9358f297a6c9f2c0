"""The matrix as one HTML page with everything in it, in the style of a campaign's report."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from html import escape

import matplotlib as mpl

from testbed.campaign.report import TEMPLATE
from testbed.campaign.report_figures import STYLE, svg
from testbed.campaign.report_tables import number, table
from testbed.study.fault_matrix.figures import figures
from testbed.study.fault_matrix.matrix import Entry, matrix
from testbed.study.study import Row, StudyRow

CAPTIONS = {
    "delay": "How long until the faulty sensor is accused, by an alarm or by a flag that names its signal; – where "
    "that share is not told within the watched time. Grey: no monitor guards the sensor against this fault. White: "
    "the sensor cannot have it.",
    "missed": "Faults that nobody tells.",
    "isolation": "Whether the first accusation is the right one.",
    "false-accusations": "Alarms that accuse what is sound. A fault of a tyre's own sensor that is called a low tyre "
    "counts here.",
    "events": "What only looks like a fault. Right: a wheel that in truth does not roll as the car moves, the flat "
    "tyre.",
}
NOTE = (
    "A trial: the fault begins on an ordinary drive at a random moment; wheel and sign are drawn. 95 % intervals of "
    "every figure are in the JSON of the study."
)


def page(title: str, rows: Sequence[Row], summary: Sequence[StudyRow]) -> str:
    """HTML."""
    with mpl.rc_context(STYLE | {"axes.grid": False}):
        drawn = {name: svg(figure) for name, figure in figures(rows).items()}
    parts = [f"<h1>{escape(title)}</h1>", _overall(summary), f'<p class="note">{NOTE}</p>']
    parts += [_figure(drawn[name], caption, i) for i, (name, caption) in enumerate(
        ((n, c) for n, c in CAPTIONS.items() if n in drawn), 1)]  # fmt: skip
    parts += ["<h2>Who tells, and who is accused besides</h2>", _cells(list(matrix(rows).values()))]
    head = TEMPLATE.read_text().partition("<body>")[0].replace("$question", escape(title))
    return head + "<body>\n" + "\n".join(parts) + "\n</body>\n</html>\n"


def _figure(drawing: str, caption: str, count: int) -> str:
    data = base64.b64encode(drawing.encode()).decode()
    return (
        f'<figure><img alt="{caption}" src="data:image/svg+xml;base64,{data}">'
        f"<figcaption>Figure {count}. {caption}</figcaption></figure>"
    )


def _overall(summary: Sequence[StudyRow]) -> str:
    told = [row for row in summary if "=" not in row.name]
    cells = [("", (row.name.replace("_", " "), number(row.here), _interval(row), row.unit)) for row in told]
    return table(("figure", "here", "95 %", "unit"), cells, 1)


def _interval(row: StudyRow) -> str:
    return "" if row.ci95 is None else f"{number(row.ci95[0])} to {number(row.ci95[1])}"


def _cells(entries: Sequence[Entry]) -> str:
    lines, last = [], ""
    for entry in entries:
        sensor = entry.cell.sensor.name.format(wheel="WHEEL")
        cells = (
            sensor if sensor != last else "", escape(entry.cell.shown), escape(entry.by) or "nobody",
            escape(entry.others), f"{entry.trials - entry.missed} of {entry.trials}",
        )  # fmt: skip
        lines.append(("group" if sensor != last else "", cells))
        last = sensor
    return table(("sensor", "fault", "told by", "accused besides", "told"), lines, 4)
