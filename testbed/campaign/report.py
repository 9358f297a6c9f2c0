"""The report of a campaign: one HTML page with everything in it, so it opens from the disk and goes by mail."""

from __future__ import annotations

import base64
from collections import Counter
from collections.abc import Mapping, Sequence
from html import escape
from itertools import groupby
from pathlib import Path
from string import Template
from typing import Any

from estimators.whole_file import write_whole
from testbed.campaign.code_version import code_version
from testbed.campaign.parts import Row
from testbed.campaign.plan import Campaign
from testbed.campaign.progress import described, shown
from testbed.campaign.replay import is_plain
from testbed.campaign.report_figures import detection_curves, error_over_time, heat_maps, roc_and_det
from testbed.campaign.report_tables import (
    alarm_table,
    driven_table,
    estimate_table,
    number,
    statistic_table,
    table,
)

TEMPLATE = Path(__file__).with_name("report.html")
NAME = "report.html"
Figures = Mapping[str, Any]

INTERVALS = (
    "Under each figure its 95 % interval. A drive is one sample, however long it is: its wheels and seconds are no "
    "more drives."
)
ESTIMATES = (
    "RMSE, bias and std over drives and time. Settled: from when on the error of every wheel stays below {bounds} to "
    "the end; median over drives. NEES: mean of (error / reported std)², 1 if the reported std is true, above if it is "
    "too small; 68.3 % of the errors should lie within 1 std. A change less the mean of the four wheels has no bias "
    "over all four."
)
ALARMS = (
    "A tyre is low once it has lost {low:g} % of nominal pressure. Times run from then; drives that end without an "
    "alarm are censored, not left out. Right wheel: of the drives with an alarm, those that name exactly the low "
    "tyres. False: an alarm while no tyre is low; Garwood's interval holds for none seen, too."
)
WORST = (
    "Largest error of all of a method's quantities together. The recording opens in the viewer that came with the "
    "set-up; the second command drives it again."
)


def write_report(campaign: Campaign, rows: Sequence[Row], scores: Figures, file: Path, folder: Path) -> Path:
    """Writes FOLDER/report.html, whole or not at all; its path. file: of the campaign."""
    page = Template(TEMPLATE.read_text()).substitute(_contents(campaign, rows, scores, file, folder))
    path = folder / NAME
    write_whole(path, page.encode())
    return path


def _contents(campaign: Campaign, rows: Sequence[Row], scores: Figures, file: Path, folder: Path) -> dict[str, str]:
    estimates, alarms, maps = scores["estimates"], scores["alarms"], scores["maps"]
    figures = _Numbered()
    return {
        "question": escape(campaign.question),
        "summary": _summary(scores),
        "driven": _driven(campaign),
        "estimates": _estimates(estimates),
        "alarms": _alarms(alarms, scores["low_percent"]),
        "over_time": _over_time(estimates, figures),
        "detection": _detection(alarms, figures),
        "maps": _maps(maps, figures),
        "failures": _failures(scores),
        "worst": _worst(campaign, rows, scores["worst"], file, folder),
        "footer": f"Campaign file <code>{escape(str(file))}</code>; code and library versions "
        f"<code>{code_version()}</code>; every figure as JSON in <code>scores.json</code>, a row a drive in "
        "<code>drives.parquet</code>.",
    }


class _Numbered:
    """Figures with their number and caption."""

    def __init__(self) -> None:
        self._count = 0

    def __call__(self, svg: str | None, caption: str) -> str:
        if svg is None:
            return ""
        self._count += 1
        data = base64.b64encode(svg.encode()).decode()
        return (
            f'<figure><img alt="{caption}" src="data:image/svg+xml;base64,{data}">'
            f"<figcaption>Figure {self._count}. {caption}</figcaption></figure>\n"
        )


def _summary(scores: Figures) -> str:
    lines = [f"{scores['drives']} drives, {number(scores['hours'])} h; {len(scores['failed'])} failed."]
    for method, group in groupby(scores["estimates"], key=lambda e: e["method"]):
        entry = next(group)
        low, high = entry["rmse"]["ci95"]
        limits = f"{number(low)} to {'∞' if high is None else number(high)}"
        lines.append(f"{method}: {entry['label']} RMSE {number(entry['rmse']['here'])} {entry['unit']} ({limits}).")
    for entry in scores["alarms"]:
        found, false = entry["detected"], entry["false_alarms"]
        if found:
            share = f"{number(100 * found['here'])} % ({' to '.join(number(100 * v) for v in found['ci95'])})"
            lines.append(f"{entry['method']}: alarm on {share} of {entry['faulty_drives']} drives with a low tyre.")
        if false:
            lines.append(f"{entry['method']}: false alarms {false['count']} in {number(false['hours'])} h.")
    return "".join(f"<p>{escape(lines[0])}</p>") + f"<p>{escape(' '.join(lines[1:]))}</p>"


def _driven(campaign: Campaign) -> str:
    names = ", ".join(campaign.estimators) or "none"
    calibrated = any(task["calibration"] for task in campaign.tasks)
    before = "after a calibration drive of the same car at nominal pressures" if calibrated else "without a calibration"
    return f"{driven_table(described(campaign))}<p>Estimators: {escape(names)}, {before}.</p>"


def _estimates(entries: Sequence[Figures]) -> str:
    if not entries:
        return "<p>No estimate that has a truth.</p>"
    bounds = {e["unit"]: f"{number(e['settled_below'])} {e['unit']}" for e in entries}
    text = ESTIMATES.format(bounds=" or ".join(bounds.values()))
    return f'{estimate_table(entries)}<p class="note">{INTERVALS} {text}</p>'


def _alarms(entries: Sequence[Figures], low: float) -> str:
    return f'{alarm_table(entries)}<p class="note">{ALARMS.format(low=low)}</p>' if entries else "<p>No estimator.</p>"


def _over_time(entries: Sequence[Figures], figures: _Numbered) -> str:
    """A figure for each quantity of the wheels; those of the whole car side by side."""
    drawn = []
    caption = "Line: bias with its interval; pale: 5 to 95 % of the drives."
    for entry in entries:
        if entry["wheels"]:
            panels = [(wheel, wheel, found["over_time"]) for wheel, found in entry["wheels"].items() if found]
            name = f"{escape(entry['method'])}, error of the {escape(entry['label'])}. {caption}"
            drawn.append(figures(error_over_time(panels, entry["unit"]), name))
    whole = [entry for entry in entries if not entry["wheels"]]
    for (method, unit), group in groupby(whole, key=lambda e: (e["method"], e["unit"])):
        panels = [(entry["label"], None, entry["over_time"]) for entry in group]
        for start in range(0, len(panels), 4):
            name = f"{escape(method)}, error of quantities of the whole car. {caption}"
            drawn.append(figures(error_over_time(panels[start : start + 4], unit), name))
    return "".join(drawn) or "<p>No estimate that has a truth.</p>"


def _detection(alarms: Sequence[Figures], figures: _Numbered) -> str:
    curves = figures(
        detection_curves(alarms),
        "Share of drives with a low tyre that have an alarm, with its 95 % band (Kaplan-Meier).",
    )
    shares = figures(
        roc_and_det(alarms),
        "What the estimates tell at any threshold on a drive's largest loss at its end: low tyres of drives that have "
        "one against any wheel of sound drives. Left with 95 % limits, right on Gaussian axes.",
    )
    return (curves + shares + statistic_table(alarms)) or "<p>No drive had a low tyre.</p>"


def _maps(maps: Figures | None, figures: _Numbered) -> str:
    if not maps or not maps["maps"]:
        return "<p>No field differs from drive to drive.</p>"
    counts = [cell["drives"] if cell else 0 for entry in maps["maps"] for column in entry["cells"] for cell in column]
    fewest, most = min(counts), max(counts)
    cell = f"{most}" if fewest == most else f"{fewest} to {most}"
    caption = f"RMSE over drives, time and wheels; {cell} drives a cell."
    return figures(heat_maps(maps), caption)


def _failures(scores: Figures) -> str:
    failed = scores["failed"]
    if not failed:
        return f"<p>None of {scores['drives']} drives.</p>"
    numbers: dict[str, list[str]] = {}
    for entry in failed:
        numbers.setdefault(entry["error"], []).append(str(entry["number"]))
    counts = Counter({error: len(found) for error, found in numbers.items()})
    rows = [("", (escape(error), ", ".join(numbers[error][:10]), str(n))) for error, n in counts.most_common()]
    told = f"<p>{len(failed)} of {scores['drives']} drives failed and are not judged.</p>"
    return told + table(("error", "drives (the first ten)", "count"), rows, 2)


def _worst(campaign: Campaign, rows: Sequence[Row], worst: Mapping[str, int], file: Path, folder: Path) -> str:
    lines = []
    for method, n in worst.items():
        task = campaign.tasks[n]
        recording = f"drive-{n}.rrd"
        again = f"python -m testbed.campaign {file} --replay {n} --out {folder}"
        if is_plain(task):
            again = f"python -m testbed.drive --scenario {folder / f'worst-{method}.json'}"
        fields = ", ".join(f"{name} {_short(rows[n][name])}" for name in task["variables"])
        cells = (escape(method), f'<a href="{recording}">drive {n}</a>', escape(fields),
                 f"<code>rerun {escape(str(folder / recording))}</code><br><code>{escape(again)}</code>")  # fmt: skip
        lines.append(("group", cells))
    if not lines:
        return "<p>No estimate that has a truth.</p>"
    heads = ("method", "recording", "driven", "to open it, to drive it again")
    return table(heads, lines, 4) + f'<p class="note">{WORST}</p>'


def _short(value: Any) -> str:
    return number(value) if isinstance(value, float) else shown(value)
