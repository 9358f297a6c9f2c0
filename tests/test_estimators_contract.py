"""Claims that hold for every registered estimator, whatever its method."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache

import numpy as np
import pytest

from estimators.car import Car
from estimators.drive_log import DriveLog, Signal
from estimators.estimator import Estimator, Outputs
from estimators.registry import check_declaration, registered, select
from estimators.runner import Bank, run
from tests.synthetic_drive import Noise, drive, varied_speed

NAMES = tuple(registered())
EACH = pytest.mark.parametrize("name", NAMES)


@cache
def log() -> DriveLog:
    """20 s with a stop at the start, noise and a curve; long enough for every method to say something."""
    speed = np.concatenate([np.zeros(300), np.linspace(0.0, 14.0, 500), varied_speed(12.0, 15.0, 1.0)])
    return drive(speed, curvature=2e-4, noise=Noise(), seed=3, hubs=True)


def edited(change: Callable[[str, Signal], Signal | None]) -> DriveLog:
    """The log with every bus signal passed through `change`; None removes it."""
    changed = {name: change(name, signal) for name, signal in log().visible().items()}
    return DriveLog({name: signal for name, signal in changed.items() if signal is not None}, log().notes)


def with_values(signal: Signal, where: slice, value: float) -> Signal:
    values = signal.value.copy()
    values[where] = value
    return Signal(signal.time, values, signal.unit, signal.frame)


def assert_sound(said: Mapping[str, Signal], name: str) -> None:
    """Estimates and stds are finite, stds not negative, times rise, and each estimate has its std."""
    for path, signal in said.items():
        if signal.value.dtype.kind == "O":
            assert path in (f"alarm/{name}", f"est/{name}/flags")
            continue
        assert np.isfinite(signal.value).all(), path
        assert (np.diff(signal.time) > 0.0).all(), path
        if path.endswith("/std"):
            assert (signal.value >= 0.0).all(), path
        else:
            assert said[f"{path}/std"].time.tolist() == signal.time.tolist()


def flags(said: Mapping[str, Signal], name: str) -> str:
    return " | ".join(said[f"est/{name}/flags"].value) if f"est/{name}/flags" in said else ""


def test_at_least_the_wheel_radius_estimator_is_found() -> None:
    assert "wheel_radius" in NAMES


@EACH
def test_a_clean_drive_gives_estimates_with_finite_stds(name: str) -> None:
    said = run(log(), [name])
    assert any(path.endswith("/std") for path in said)
    assert_sound(said, name)


@EACH
@pytest.mark.parametrize("stretch", [0.037, 0.5, 100.0])
def test_result_does_not_depend_on_how_the_stream_is_cut(name: str, stretch: float) -> None:
    messy = edited(lambda path, s: Signal(*_disordered(s), s.unit, s.frame))
    assert run(messy, [name], stretch) == run(messy, [name], 1.0)


def _disordered(signal: Signal) -> tuple[np.ndarray, np.ndarray]:
    """A NaN burst, late, repeated and wild stamps, and two seconds of silence."""
    time, value = signal.time.copy(), signal.value.copy()
    value[1200:1230] = np.nan
    time[1400], time[1500], time[1600] = time[1390], time[1499], 5e8
    kept = (time < 16.5) | (time > 18.8)
    return time[kept], value[kept]


@EACH
def test_the_same_log_gives_the_same_bytes(name: str) -> None:
    assert run(log(), [name]) == run(log(), [name])


@EACH
def test_a_burst_of_nan_in_any_signal_is_flagged(name: str) -> None:
    for target in registered()[name].reads:
        said = run(
            edited(lambda path, s, t=target: with_values(s, slice(1500, 1700), np.nan) if path == t else s), [name]
        )
        assert_sound(said, name)
        assert f"{target}: not a finite number" in flags(said, name)


@EACH
@pytest.mark.parametrize("value", [np.inf, -np.inf, 1e300, -1e300])
def test_a_burst_of_absurd_values_in_all_signals_is_survived(name: str, value: float) -> None:
    assert_sound(run(edited(lambda path, s: with_values(s, slice(1500, 1700), value)), [name]), name)


@EACH
def test_silence_of_any_signal_is_flagged(name: str) -> None:
    def without(signal: Signal) -> Signal:
        kept = (signal.time < 12.0) | (signal.time > 15.0)
        return Signal(signal.time[kept], signal.value[kept], signal.unit, signal.frame)

    for target in registered()[name].reads:
        said = run(edited(lambda path, s, t=target: without(s) if path == t else s), [name])
        assert_sound(said, name)
        assert f"{target}: no usable sample for 1 s" in flags(said, name)


@EACH
def test_an_absent_signal_is_flagged_and_without_a_required_one_nothing_is_estimated(name: str) -> None:
    kind = registered()[name]
    for target in kind.reads:
        said = run(edited(lambda path, s, t=target: None if path == t else s), [name])
        assert_sound(said, name)
        assert target in flags(said, name)
        if target in kind.requires:
            assert not any(path.endswith("/std") for path in said)


@EACH
def test_without_any_of_what_it_needs_one_of_nothing_is_estimated(name: str) -> None:
    needed = registered()[name].requires_any
    without = edited(lambda path, s: None if path in needed else s)
    if needed:
        assert not any(path.endswith("/std") for path in run(without, [name]))
    assert Bank([name], Car()).missing(without) == ({name: list(needed)} if needed else {})
    assert not Bank([name], Car()).missing([*without, *needed[:1]])


@EACH
def test_late_repeated_and_wild_stamps_are_flagged(name: str) -> None:
    target = (registered()[name].requires + registered()[name].requires_any)[0]
    said = run(edited(lambda path, s: Signal(*_disordered(s), s.unit, s.frame) if path == target else s), [name])
    assert_sound(said, name)
    for complaint in ("late time stamps", "repeated time stamps", "far ahead"):
        assert f"{target}: " in flags(said, name)
        assert complaint in flags(said, name)


@EACH
def test_signals_of_a_wrong_shape_are_flagged(name: str) -> None:
    target = (registered()[name].requires + registered()[name].requires_any)[0]
    for wrong in (lambda s: Signal(s.time, np.ones((len(s), 2))), lambda s: Signal(s.time, ["x"] * len(s))):
        said = run(edited(lambda path, s, w=wrong: w(s) if path == target else s), [name])
        assert f"{target}: value is" in flags(said, name)


@EACH
@pytest.mark.parametrize("content", [{}, {"wheel/fl/speed": Signal([], [])}])
def test_an_empty_log_is_no_error(name: str, content: dict[str, Signal]) -> None:
    assert not any(path.endswith("/std") for path in run(DriveLog(content), [name]))


class Guarded(Mapping[str, Signal]):
    """A log that cannot be asked for what an estimator may not know."""

    def __init__(self, signals: Mapping[str, Signal]) -> None:
        self._signals = signals

    def _check(self, name: object) -> None:
        assert not str(name).startswith(("truth/", "est/", "alarm/")), f"asked for {name}"

    def __getitem__(self, name: str) -> Signal:
        self._check(name)
        return self._signals[name]

    def __contains__(self, name: object) -> bool:
        self._check(name)
        return name in self._signals

    def __iter__(self):
        raise AssertionError("an estimator asks for the signals that it declared, it does not browse")

    def __len__(self) -> int:
        return len(self._signals)


@EACH
def test_no_estimator_asks_for_truth_or_browses(name: str) -> None:
    estimator = registered()[name](Car())
    assert estimator.update(Guarded(log()), 30.0).estimates


@EACH
def test_outputs_share_no_memory_with_inputs(name: str) -> None:
    outputs = registered()[name](Car()).update(log().visible(), 30.0)
    inputs = [array for signal in log().values() for array in (signal.time, signal.value)]
    for estimate in outputs.estimates.values():
        for array in (estimate.time, estimate.value, estimate.std):
            assert not any(np.shares_memory(array, given) for given in inputs)


@EACH
def test_a_calibration_survives_the_way_there_and_back(name: str) -> None:
    kind = registered()[name]
    learnt = kind(Car())
    learnt.update(drive(varied_speed(140.0), noise=Noise(), seed=1, hubs=True).visible(), 150.0)
    document = learnt.calibration()
    if document is None:
        pytest.skip(f"{name} learns no calibration")
    again = kind(Car())
    again.use_calibration(document)
    assert again.calibration() == document


class _Reader(Estimator):
    name = "reader"
    requires = ()

    def update(self, samples: Mapping[str, Signal], until: float) -> Outputs:
        return Outputs()


@pytest.mark.parametrize("path", ["truth/fl/load", "est/wheel_radius/delta12", "alarm/wheel_radius"])
def test_a_declaration_of_hidden_signals_is_refused(path: str) -> None:
    kind = type("Peeker", (_Reader,), {"reads": (path,)})
    with pytest.raises(ValueError, match="no estimator may read"):
        check_declaration(kind)


def test_requiring_an_undeclared_signal_is_refused() -> None:
    kind = type("Undeclared", (_Reader,), {"reads": (), "requires": ("imu/gyro",)})
    with pytest.raises(ValueError, match="does not declare"):
        check_declaration(kind)


def test_an_unknown_name_lists_the_valid_ones() -> None:
    with pytest.raises(ValueError, match=r"no estimator 'magic', valid: .*wheel_radius"):
        select(["magic"])
    with pytest.raises(ValueError, match="no estimator 'magic'"):
        Bank(None, Car(), {"magic": {}})


@pytest.mark.parametrize("stretch", [0.0, -1.0, np.nan])
def test_a_stretch_that_is_no_length_of_time_is_refused(stretch: float) -> None:
    with pytest.raises(ValueError, match="stretch is"):
        run(log(), stretch=stretch)


@pytest.mark.parametrize(
    ("car", "complaint"),
    [
        ({"mass_total": 1.0}, "no field 'mass_total', valid: .*chassis_mass"),
        ({"chassis_mass": -1.0}, "chassis_mass is -1.0"),
        ({"rear_track": float("nan")}, "rear_track is nan"),
        ({"rolling_radius": "big"}, "rolling_radius is 'big'"),
        ({"rolling_radius": True}, "rolling_radius is True"),
        ({"driven_axle": "left"}, "driven_axle is 'left', valid: front, rear, all"),
        ([1], r"notes\['car'\] is \[1\]"),
    ],
)
def test_a_nonsense_car_is_refused_in_one_line(car: object, complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint) as caught:
        Car.from_notes({"car": car})
    assert "\n" not in str(caught.value)


def test_a_log_without_a_car_gets_the_default_and_a_given_field_counts() -> None:
    assert Car.from_notes({}) == Car()
    assert Car.from_notes({"car": {"rear_track": 1.5}}) == Car(rear_track=1.5)
    assert Car().wheelbase == pytest.approx(2.818)
