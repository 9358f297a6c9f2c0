"""The thesis' tables of 4.2.2 (Razavi, Lund 2006, seed 004): seconds to the alarm in each of ten scenarios.

x: none; a letter: of which residual (p, v, a); *: a short alarm at the beginning came before. None where a table has no
such method.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

from estimators.steering_actuator.residuals import RESIDUALS

SCENARIOS = 10
_TABLES = """
no_error
CUSUM x x x x x x x x x x
ACS x x 2.9 1.8 x 1.8 x x 2.0 x
ACF x x 3.0 1.9 x x x x x x
AC x x x x x x x x x x
GMA x x x x x x x x x x
LCUSUM x x x x x x x x x x
double_LCUSUM x x x x x x x x x x
double_CUSUM x x x x x x x x x x
double_LGCUSUM x x x x x x x x x x
ADYN x x x* x x* x x* x x x
constant_20
CUSUM x x 7.3 x x x x x x x
ACS x x 2.9 1.8 x 1.8 x x 2.0 x
ACF x x 3.1 1.9 x x x x x x
AC x x x x x x x x x x
GMA x x x x x x x x x x
LCUSUM x 9.3p x x 8.9p 5.5p 4.8p x x x
double_LCUSUM x 8.8 x x x 5.3p 5.2p x x x
double_CUSUM x x 6.2 x x x x x x x
double_LGCUSUM x x x x x x 8.0 x x x
ADYN x x* x* x x* x* x x x x
constant_30
LCUSUM 3.7p 3.2p x 7.8p 4.0p 4.9p 4.3p 3.4p 5.8p 3.6p
constant_50
CUSUM x x 6.1 x x x x x x x
ACS x x 2.9 1.8 x 1.8 x x 2.0 x
ACF x x 3.1 1.9 x x x x x x
AC x x x x x x x x x x
GMA x x 7.4 x x x x x x x
LCUSUM 2.0p 2.3p 2.6p 3.8p 2.5p 3.0p 3.5p 2.2p 3.2p 2.8p
double_LCUSUM 2.8p 2.7p 3.5p 4.1p 3.6p 2.6p 3.7p 2.7p 3.7p 3.2p
double_CUSUM x x 6.1 x x x x x x x
double_LGCUSUM 7.3 6.3 6.1 x x x 5.6 6.7 8.4 7.1
ADYN x x* x* x x* x* x x x x
constant_100
CUSUM x x 5.1 2.7 x x x x x x
ACS x x 2.0 1.8 x 1.8 x x 1.9 x
ACF x x 3.1 1.9 x x x x x x
AC x x x x x x x x x x
GMA x x 6.1 x x x x x x x
LCUSUM 2.0p 1.6p 2.3p 2.5p 2.5p 1.6p 1.5p 1.6p 2.6p 1.8p
double_LCUSUM 1.7p 1.9p 1.8p 2.4p 1.8p 2.1p 1.9p 1.8p 2.3p 2.0p
double_CUSUM x x 4.0 4.3 x 4.9 8.4 x 8.7 x
double_LGCUSUM 3.5 3.1 4.0 4.2 4.0 5.0 2.9 3.1 4.6 3.2
ADYN x x* x* x x* x* x x x x
constant_500
double_LGCUSUM 0.5 0.6 0.6 0.8 0.4 0.7 0.5 0.6 0.7 0.6
ADYN x x* 4.0* x x* x* x x x x
constant_1000
double_LGCUSUM 0.2 0.3 0.3 0.3 0.2 0.3 0.2 0.3 0.3 0.2
ADYN x x* 1.9* 1.0 x* 1.6* x x 0.9 x
constant_1500
double_LGCUSUM 0.2 0.2 0.2 0.2 0.2 0.2 0.2 0.2 0.2 0.2
ADYN 0.2 0.2 0.2 0.2 0.0 0.2 0.2 0.2 0.2 0.2
noise_50
CUSUM x x 7.3 x x x x x x x
ACS x x 2.9 1.8 x 1.8 x x 2.0 x
ACF x x 3.0 1.9 x x x x x x
AC x x 6.3 x x x x x x x
GMA x x 9.5 x x x x x x x
LCUSUM x x x x 2.3v 5.3p 6.2p x x 5.2p
double_LCUSUM x 5.7v 6.6a x 2.2v 4.0p 2.0a x 4.1v 5.2p
double_CUSUM x x 8.2 x x x x x x x
double_LGCUSUM 4.7 2.7 2.6 3.8 3.7 3.8 4.8 5.3 5.2 5.4
ADYN x x* x* x x* x* x x x x
noise_100
CUSUM x x 7.3 x x x x x x x
ACS x x 2.9 1.8 x 1.8 x x x x
ACF x x 3.0 1.9 x x x x x x
AC x x 6.3 x x x x x x x
GMA x x 7.4 x x x x x x x
LCUSUM 7.4v 6.2p 7.0v x 2.3v 2.5v 4.6p 7.7p 7.5p 2.9p
double_LCUSUM x 5.8v 3.7a 5.7v 2.3v 2.5v 2.0a 2.1a x 5.0p
double_CUSUM x x 7.3 x x x x x x x
double_LGCUSUM 2.7 1.6 1.6 2.4 2.1 2.2 2.7 3.0 3.0 3.0
ADYN x x* x* x x* x* x x x x
sine_40
CUSUM 7.1a 9.6a 2.9a 2.2a 6.3a 5.5a x x 8.3a x
ACS x x 2.9 1.8 x 1.8 x x 2.0 x
ACF x x 3.0 1.9 x x x x x x
AC x x 1.0 2.1 x 7.7 x x 2.1 x
GMA 7.1a 7.8a 4.1a 4.3a 6.4a 6.2a 7.8a 8.7a 8.3a 8.4a
LCUSUM 1.4v 1.2v 1.4v 1.5v 1.2v 1.3v 1.3v 1.2v 1.7v 1.2v
double_LCUSUM 1.6v 1.6v 1.6v 4.1v 1.5v 1.6v 1.5v 1.7v 1.4v 2.8v
double_CUSUM x x 3.1 2.7 x x x x x x
double_LGCUSUM 1.9 1.8 5.9 7.8 2.7 3.2 1.6 1.8 3.3 1.5
ADYN x x* x* x* x* x* x x x x
slope_20
CUSUM x x 7.4 x x x x x x x
ACS x x 2.9 1.8 x 1.8 x x 2.0 x
ACF x x 3.0 1.9 x x x x x x
AC x x x x x x x x x x
GMA x x x x x x x x x x
LCUSUM 8.1 8.0 8.7 8.5 7.9 8.0 6.4 8.3 7.8 7.6
double_LCUSUM 8.5p 8.2p 9.1p 8.7p 6.1v 6.3v 6.7p 8.3p 8.1p 8.2p
double_CUSUM x x 8.2 x x x x x x x
double_LGCUSUM x x 8.2 x x x 8.9 x x x
ADYN x x* x* x x* x* x x x x
slope_50
CUSUM x x 7.3 x x x x x x x
ACS 9.7 9.2 2.9 1.8 9.2 1.8 9.2 9.2 2.0 9.2
ACF x x 3.0 1.9 x x x x x x
AC x x x x x x x x x x
GMA x x 8.2 x x x x x x x
LCUSUM 6.7 6.4 6.8 6.7 6.1 6.0 5.8 6.7 6.6 6.4
double_LCUSUM 7.0p 6.7p 7.7p 7.3p 5.9v 7.1p 6.0p 6.9p 6.8p 6.8p
double_CUSUM 9.6 9.5 7.3 8.0 9.5 8.2 9.1 9.6 9.5 9.6
double_LGCUSUM 8.7 8.5 8.0 8.6 8.8 9.4 8.0 8.6 8.4 8.6
ADYN x x* x* x x* x* x x x x
slope_500
CUSUM 6.3 6.3 5.7 6.1 6.3 6.4 6.3 6.3 6.3 6.3
ACS 5.9 5.8 2.9 1.8 5.9 1.8 5.8 5.8 2.0 5.8
ACF 7.0 7.0 3.0 1.8 7.1 7.1 7.0 7.0 7.0 7.0
AC 8.0 8.0 6.1 7.8 7.9 7.5 8.0 8.1 8.0 8.1
GMA 6.7 6.7 6.0 6.2 6.6 6.7 6.7 6.7 6.7 6.7
LCUSUM 5.4 5.4 5.5 5.8 5.2 5.4 5.2 5.2 5.2 5.2
double_LCUSUM 5.5v 5.4v 5.7v 5.7v 5.3v 5.2v 5.2v 5.2v 5.2v 5.0a
double_CUSUM 6.0 6.0 5.9 6.0 6.0 6.0 6.0 6.0 6.0 6.0
double_LGCUSUM 5.8 5.6 6.0 5.9 5.9 6.2 5.4 5.3 5.3 5.3
ADYN 7.2 7.4* 6.1* 7.4 7.3* 7.3* 7.2 7.3 7.3 7.3
"""


@dataclass(frozen=True)
class Printed:
    """time: s to the alarm, None without one; by: of RESIDUALS, "" where it is not said; star: see the module."""

    time: float | None
    by: str
    star: bool

    @classmethod
    def of(cls, text: str) -> Printed:
        """As the thesis prints it."""
        star = text.endswith("*")
        bare = text.rstrip("*")
        letters = {name[0]: name for name in RESIDUALS}
        by = letters.get(bare[-1], "")
        return cls(None if bare == "x" else float(bare.rstrip("pva")), by, star)


@cache
def tables() -> dict[str, dict[str, tuple[Printed, ...]]]:
    """Error's name -> method -> ten entries."""
    found: dict[str, dict[str, tuple[Printed, ...]]] = {}
    rows: dict[str, tuple[Printed, ...]] = {}
    for line in _TABLES.strip().splitlines():
        name, *entries = line.split()
        if not entries:
            rows = found.setdefault(name, {})
        else:
            rows[name] = tuple(Printed.of(entry) for entry in entries)
    return found


def smallest_constant(method: str) -> float | None:
    """Smallest of the printed constants that a method finds in all ten scenarios, as the thesis counts it; None if
    none."""
    sizes = []
    for error, rows in tables().items():
        if error.startswith("constant_") and method in rows and all(entry.time is not None for entry in rows[method]):
            sizes.append(float(error.removeprefix("constant_")))
    return min(sizes, default=None)
