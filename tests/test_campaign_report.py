"""The report in a real browser: it renders from the disk, alone, with every figure and without an error."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import tomllib
from pathlib import Path
from typing import Any

import pytest

from testbed.campaign.judge import judge
from testbed.campaign.plan import campaign
from testbed.campaign.report import write_report
from testbed.campaign.report_figures import axis_name
from testbed.campaign.report_tables import number, with_interval
from tests.campaigns import FILE, made_up_rows

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
QUIET = (
    "--headless", "--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-component-update",
    "--disable-sync", "--no-first-run", "--virtual-time-budget=5000", "--enable-logging=stderr",
)  # fmt: skip
# what the browser made of the page, as JSON in its title
PROBE = """<script>
const errors = []; window.onerror = e => errors.push(String(e));
window.onload = () => { document.title = JSON.stringify({
  errors, fetched: performance.getEntriesByType("resource").filter(r => !r.name.startsWith("data:")).length,
  figures: [...document.images].map(i => [i.complete && i.naturalWidth > 0, i.getBoundingClientRect().width]),
  page: document.documentElement.clientWidth, wide: document.documentElement.scrollWidth,
  tables: document.querySelectorAll("table").length, height: document.body.scrollHeight}); };
</script></head>"""


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("report")
    plan = campaign(tomllib.loads(FILE.replace("seed = 2", "seed = 2\nruns = 6")))
    rows = made_up_rows(plan)
    rows[3] = {k: v for k, v in rows[3].items() if k in ("number", "task_key")} | {"error": "Diverged: <no>"}
    return write_report(plan, rows, judge(plan, rows), Path("small.toml"), folder)


def seen_by_a_browser(page: Path, folder: Path) -> tuple[dict[str, Any], str]:
    """What PROBE found, and the browser's log."""
    browser = next(filter(None, map(shutil.which, BROWSERS)), None)
    if browser is None:
        pytest.skip(f"no browser, one of {', '.join(BROWSERS)}: the report was not rendered")
    probed = folder / "probed.html"
    probed.write_text(page.read_text().replace("</head>", PROBE))
    words = [browser, *QUIET, f"--user-data-dir={folder / 'profile'}", "--dump-dom", probed.as_uri()]
    done = subprocess.run(words, capture_output=True, text=True, check=True, timeout=120.0)
    title = re.search(r"<title>(.*?)</title>", done.stdout)
    assert title
    return json.loads(title[1]), done.stderr


def test_browser_renders_every_figure_and_reports_no_error(page: Path, tmp_path: Path) -> None:
    found, log = seen_by_a_browser(page, tmp_path)
    assert found["errors"] == []
    assert "CONSOLE" not in log
    assert found["fetched"] == 0
    assert len(found["figures"]) == page.read_text().count("<figure>") == 4
    assert all(complete and width > 500 for complete, width in found["figures"])
    assert found["tables"] == 6
    assert found["wide"] <= found["page"]
    assert found["height"] > 2000


def test_page_needs_nothing_from_elsewhere(page: Path) -> None:
    text = page.read_text()
    assert not re.search(r'(?:src|href)="(?!data:|drive-\d+\.rrd")', text)
    assert "<script" not in text
    assert "http" not in re.sub(r"base64,[^\"]*", "", text)


def test_page_says_what_was_driven_and_what_failed(page: Path) -> None:
    text = page.read_text()
    for words in ("swept", "flat, C", "uniform of 150, 250", "1 of 24 drives failed", "Diverged: &lt;no&gt;"):
        assert words in text
    assert "python -m testbed.drive --scenario" in text


def test_same_rows_give_the_same_page(page: Path, tmp_path: Path) -> None:
    plan = campaign(tomllib.loads(FILE))
    texts = []
    for _ in range(2):
        rows = made_up_rows(plan)
        texts.append(write_report(plan, rows, judge(plan, rows), Path("small.toml"), tmp_path).read_text())
    assert texts[0] == texts[1]


def test_report_of_nothing_but_failures_is_a_page_too(tmp_path: Path) -> None:
    plan = campaign(tomllib.loads(FILE))
    rows = [{"number": task["number"], "error": "no", "task_key": ""} for task in plan.tasks]
    text = write_report(plan, rows, judge(plan, rows), Path("small.toml"), tmp_path).read_text()
    assert "4 of 4 drives failed" in text


@pytest.mark.parametrize(
    ("value", "text"),
    [(None, "–"), (0.0, "0"), (12.345, "12.3"), (-0.01234, "−0.0123"), (1234.5, "1230"), (98765.0, "98800"),
     (1e-5, "1.0e-05"), (1e-17, "0"), (-123456.0, "−123000")],
)  # fmt: skip
def test_numbers_have_three_digits(value: float | None, text: str) -> None:
    assert number(value) == text


def test_interval_without_a_limit_says_so() -> None:
    assert with_interval({"here": 2.0, "ci95": [1.0, None]}) == '2<span class="ci">1 to ∞</span>'
    assert with_interval({"here": None, "ci95": [None, None]}) == "not reached"
    assert with_interval(None) == "–"


def test_axis_names_have_their_unit() -> None:
    assert axis_name("speed_kmh") == "speed (km/h)"
    assert axis_name("pressure_kpa.fl") == "pressure fl (kPa)"
    assert axis_name("road") == "road"
