"""The `claim` fixture: a test asserts a measured figure against its tolerance and puts it on record.

`pytest --claims` prints the worst figure of every claim as the table in the README (`make validation`).
"""

from __future__ import annotations

from collections.abc import Callable

import pytest

Claim = Callable[[str, float, float, str], None]


@pytest.fixture
def claim(record_property: Callable[[str, object], None]) -> Claim:
    """claim(what, deviation, tolerance, unit): asserts 0 <= deviation <= tolerance, both in that unit."""

    def check(what: str, deviation: float, tolerance: float, unit: str) -> None:
        record_property(f"claim {what}", (float(deviation), tolerance, unit))
        assert 0.0 <= deviation <= tolerance, f"{what}: {deviation:.4g} {unit}, tolerance {tolerance:g} {unit}"

    return check


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--claims", action="store_true", help="print what the validation tests measured, as Markdown")


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    if not config.getoption("--claims"):
        return
    worst: dict[str, tuple[float, float, str]] = {}
    for reports in terminalreporter.stats.values():
        for report in reports:
            for name, found in getattr(report, "user_properties", ()):
                if name.startswith("claim ") and report.when == "call":
                    what = name.removeprefix("claim ")
                    worst[what] = max(worst.get(what, found), found)
    terminalreporter.write_line("| claim | tolerance | measured, worst case |\n|---|---|---|")
    for what, (deviation, tolerance, unit) in worst.items():
        terminalreporter.write_line(f"| {what} | {tolerance:g} {unit} | {deviation:.2g} {unit} |")
