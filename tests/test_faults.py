"""Claims that hold for every kind of sensor fault, and what each kind does, in closed form."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import pairwise

import numpy as np
import pytest

from estimators.drive_log import WHEELS, DriveLog, Signal
from estimators.faults import Injector, fault_kinds, inject, parse_fault
from estimators.faults.truth import fault_events, sound_signals

TEETH, SPEED, SECONDS = 48, 50.0, 6.0
PITCH = 2.0 * math.pi / TEETH
FROM, TO = 2.0, 4.0
KINDS = tuple(fault_kinds())
NUMBERS = {"bias": ":2", "scale": ":1.1", "spike": ":5,0.2", "noise": ":3", "drift": ":1", "delay": ":0.3",
           "dropout": ":0.3", "intermittent": ":0.1,0.5", "teeth": ":44", "sine": ":2,1", "hiss": ":3"}  # fmt: skip
ROUNDING = 1e-12  # of values of order one, added and taken away again
STEADY = 1e-6  # of a steady wheel's speed: edges lie on a grid of 1 ns


def log() -> DriveLog:
    """Wheels that turn steadily, each at its own speed, and an inertial unit that says sines."""
    time = np.arange(0.0, SECONDS, 0.01)
    signals = {}
    for i, wheel in enumerate(WHEELS):
        speed = SPEED + i
        edges = np.arange(0.5, SECONDS * speed / PITCH) * PITCH / speed
        signals[f"wheel/{wheel}/edges"] = Signal(edges, np.arange(1.0, len(edges) + 1.0))
        signals[f"wheel/{wheel}/speed"] = Signal(time, np.full(len(time), speed), "rad/s")
        signals[f"tyre/{wheel}/pressure"] = Signal(time[::100], 2e5 + time[::100], "Pa")
    fast = np.arange(0.0, SECONDS, 0.001)
    waves = np.stack([np.sin(fast), np.cos(3.0 * fast), np.sin(5.0 * fast)], axis=1)
    return DriveLog(signals | {"imu/accel": Signal(fast, waves, "m/s^2", "imu")}, {"scenario": {"seed": 3}})


def fault(kind: str, sensor: str = "wheel/rr", when: str = f"@{FROM:g}-{TO:g}") -> str:
    return f"{sensor}={kind}{NUMBERS.get(kind, '')}{when}"


def streamed(faults: list[str], stretch: float, seed: int = 0) -> dict[str, Signal]:
    """The log through an injector in stretches."""
    injector, parts = Injector(faults, seed, float(TEETH)), []
    marks = np.append(np.arange(0.0, SECONDS, stretch), SECONDS)
    for start, end in pairwise(marks):
        parts.append(injector.update({n: s.between(start, end) for n, s in log().items()}, end))
    joined = {}
    for name in parts[0]:
        signals = [part[name] for part in parts]
        time, value = (np.concatenate([getattr(s, what) for s in signals]) for what in ("time", "value"))
        joined[name] = Signal(time, value, signals[0].unit, signals[0].frame)
    return joined


def rate(edges: Signal, start: float, end: float) -> float:
    """Wheel speed [rad/s] that edges between two times tell."""
    inside = edges.between(start, end).time
    return (len(inside) - 1) * PITCH / float(inside[-1] - inside[0]) if len(inside) > 1 else 0.0


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("stretch", [0.037, 1.0])
def test_a_fault_does_not_depend_on_how_the_stream_is_cut(kind: str, stretch: float) -> None:
    faults = [fault(kind), fault("bias", "imu/accel/y")]
    whole = streamed(faults, SECONDS)
    assert streamed(faults, stretch) == whole
    changed = [name for name, signal in whole.items() if signal != log()[name]]
    assert {"wheel/rr/edges", "imu/accel"} <= set(changed)
    assert set(changed) <= {"wheel/rr/edges", "wheel/rr/speed", "wheel/rl/edges", "wheel/rl/speed", "imu/accel"}


@pytest.mark.parametrize("kind", KINDS)
def test_the_same_seed_gives_the_same_bytes_and_another_one_only_where_it_draws(kind: str) -> None:
    first, again, other = (streamed([fault(kind)], 1.0, seed) for seed in (5, 5, 6))
    assert first == again
    assert (first == other) == (kind not in ("spike", "noise", "hiss", "dropout", "intermittent"))


@pytest.mark.parametrize("kind", KINDS)
def test_outside_its_time_a_fault_changes_nothing(kind: str) -> None:
    changed = streamed([fault(kind)], 1.0)
    late = 0.3 if kind == "delay" else 0.0
    for name, signal in log().items():
        for start, end in ((0.0, FROM), (TO + late, SECONDS)):
            before, after = signal.between(start, end), changed[name].between(start, end)
            assert np.array_equal(before.time, after.time), name
            if not name.endswith("/edges"):
                assert np.array_equal(before.value, after.value), name
    for wheel in WHEELS:
        edges = changed[f"wheel/{wheel}/edges"]
        assert (np.diff(edges.value) == 1.0).all()
        assert (np.diff(edges.time) > 0.0).all()


@pytest.mark.parametrize("kind", KINDS)
def test_an_axis_or_a_whole_vector_can_be_faulty(kind: str) -> None:
    if fault_kinds()[kind].wheels_only or kind == "swap":
        return
    sound, inside = log()["imu/accel"], slice(2100, 3900)
    if fault_kinds()[kind].whole:
        with pytest.raises(ValueError, match="whole messages; valid: imu/accel"):
            parse_fault(fault(kind, "imu/accel/y"))
        assert streamed([fault(kind, "imu/accel")], 1.0)["imu/accel"] != sound
        return
    one = streamed([fault(kind, "imu/accel/y")], 1.0)["imu/accel"].value
    every = streamed([fault(kind, "imu/accel")], 1.0)["imu/accel"].value
    assert np.array_equal(one[:, [0, 2]], sound.value[:, [0, 2]])
    for column, value in ((1, one), (0, every), (1, every), (2, every)):
        assert not np.array_equal(value[inside, column], sound.value[inside, column])


@pytest.mark.parametrize(
    ("there", "back"),
    [
        ("bias:2", "bias:-2"),
        ("scale:1.25", "scale:0.8"),
        ("drift:0.5", "drift:-0.5"),
        ("spike:3,0.1", "spike:-3,0.1"),
        ("sine:3,7", "sine:-3,7"),
    ],
)
def test_a_fault_and_its_inverse_leave_the_signal(there: str, back: str) -> None:
    result = streamed([f"imu/accel/x={there}@2", f"imu/accel/x={back}@2"], 0.3)["imu/accel"]
    assert np.abs(result.value - log()["imu/accel"].value).max() < ROUNDING


def test_two_exchanges_are_none() -> None:
    assert streamed([fault("swap"), fault("swap", "wheel/rl")], 0.3) == dict(log())


# kind -> speed that the faulty sensor tells between two times inside the fault
STEADY_SPEED = {"bias:2": SPEED + 5.0, "scale:1.1": 1.1 * (SPEED + 3.0), "zero": 0.0, "stuck": SPEED + 3.0,
                "drift:1": SPEED + 4.0, "teeth:44": (SPEED + 3.0) * 44 / 48, "swap": SPEED + 2.0}  # fmt: skip


@pytest.mark.parametrize(("what", "speed"), STEADY_SPEED.items())
def test_edges_and_bus_speed_tell_the_same_faulty_speed(what: str, speed: float) -> None:
    said = streamed([f"wheel/rr={what}@2-4"], 1.0)
    start, end = (2.5, 3.5)
    bus = said["wheel/rr/speed"].between(start, end).value.mean()
    assert bus == pytest.approx(speed, rel=STEADY, abs=0.01)  # the ramp's mean: 100 samples from 2.5 s on
    one_pitch = PITCH / (end - start)
    assert rate(said["wheel/rr/edges"], start, end) == pytest.approx(speed, rel=STEADY, abs=0.1 * one_pitch)


@pytest.mark.parametrize("what", ["noise:3", "spike:9,0.3", "intermittent:0.2,0.7"])
def test_random_faults_hit_edges_and_bus_speed_in_the_same_cells(what: str) -> None:
    said = streamed([f"wheel/rr={what}@2-4"], 1.0)
    told = np.abs(said["wheel/rr/speed"].between(FROM, TO).value)
    turned = np.cumsum(told) * 0.01 / PITCH
    at = FROM + 0.01 * np.arange(1, len(told) + 1)
    counted = np.searchsorted(said["wheel/rr/edges"].between(FROM, TO).time, at, side="right")
    assert np.abs(counted - turned).max() <= 1.0 + 1e-6  # an edge is whole, an angle is not


def test_random_numbers_have_their_distribution() -> None:
    """Share of spikes, share of lost samples, mean and standard deviation of noise, time open: within four standard
    errors of 4000 samples, which 1 in 16 000 seeds would miss."""
    n, four = 4000, 4.0 / math.sqrt(4000)
    said = {k: streamed([fault(k, "imu/accel", "@1-5")], 1.0)["imu/accel"].between(1.0, 5.0)
            for k in ("noise", "spike", "dropout", "intermittent")}  # fmt: skip
    sound = log()["imu/accel"].between(1.0, 5.0)
    noise = said["noise"].value / 3.0
    assert np.abs(noise.mean(axis=0)).max() < four
    assert np.abs(noise.std(axis=0) - 1.0).max() < four / math.sqrt(2.0)
    assert np.abs(np.corrcoef(noise.T)[np.triu_indices(3, 1)]).max() < four
    assert abs(np.corrcoef(noise[1:, 0], noise[:-1, 0])[0, 1]) < four
    hit = np.abs(said["spike"].value - sound.value)[:, 0] > 1.0
    assert abs(hit.mean() - 0.2) < 0.4 * four
    assert abs(1.0 - len(said["dropout"]) / n - 0.3) < 0.46 * four
    zero = (said["intermittent"].value == 0.0).all(axis=1)
    assert zero.mean() == pytest.approx(0.1 / 0.5, abs=8 / n)  # eight periods, a sample each


def test_stuck_keeps_the_last_finite_value_and_delay_moves_stamps() -> None:
    values = np.arange(600.0)
    values[195:200] = np.nan
    sound = DriveLog({"steering/angle": Signal(0.01 * np.arange(600), values, "rad")})
    stuck = inject(sound, ["steering/angle=stuck@2-4"])["steering/angle"]
    assert (stuck.between(2.0, 4.0).value == 194.0).all()
    from_the_start = inject(sound, ["steering/angle=stuck"])["steering/angle"]
    assert (from_the_start.value == 0.0).all()
    late = inject(sound, ["steering/angle=delay:0.25@2-4"])["steering/angle"]
    moved = late.value[(late.value >= 200) & (late.value < 400)]
    assert len(late) == 600
    assert moved[0] == 200.0
    assert late.time[late.value == 200.0] == pytest.approx([2.25])
    assert (np.diff(late.time) >= 0.0).all()


def test_a_fault_in_the_units_of_its_sensor() -> None:
    """deg, kPa as typed; SI inside."""
    assert parse_fault("imu/gyro/z=bias:1").numbers == pytest.approx((math.pi / 180.0,))
    assert parse_fault("tyre/rl/pressure=drift:-2").numbers == (-2000.0,)
    assert parse_fault("steering/angle=spike:180").numbers == pytest.approx((math.pi, 0.01))
    assert parse_fault("imu/accel=scale:0.5@3").numbers == (0.5,)


def test_wild_stamps_and_text_are_survived() -> None:
    signals = dict(log())
    time = signals["wheel/rr/edges"].time.copy()
    time[100] = 5e8
    signals["wheel/rr/edges"] = Signal(time, signals["wheel/rr/edges"].value)
    for kind in KINDS:
        result = inject(DriveLog(signals), [fault(kind, when="@2")])
        assert len(result["wheel/rr/edges"]) < 3 * len(time)
    signals["steering/angle"] = Signal([0.0], ["left"])
    with pytest.raises(ValueError, match="the log has no steering/angle"):
        inject(DriveLog(signals), ["steering/angle=zero"])


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("", ["want SENSOR=KIND"]),
        ("imu/accel/x", ["want SENSOR=KIND"]),
        ("radar=zero", ["'radar'", "imu/accel[/x|y|z]", "wheel/WHEEL"]),
        ("wheel/r=zero", ["'wheel/r'"]),
        ("wheel/{}=zero", ["'wheel/{}'"]),
        ("imu/accel/w=zero", ["'imu/accel/w'"]),
        ("imu/accel=broken", ["'broken'", "bias", "teeth"]),
        ("imu/accel=bias", ["0 numbers", "bias:SIZE"]),
        ("imu/accel=bias:1,2", ["2 numbers", "bias:SIZE"]),
        ("imu/accel=bias:x", ["'x'", "m/s^2"]),
        ("imu/accel=bias:nan", ["'nan'"]),
        ("imu/accel=bias:1e99", ["1e99"]),
        ("wheel/fl=dropout:2", ["'2'", "0 to 1"]),
        ("imu/accel=bias:1@5-3", ["ends at 3 s", "5 s"]),
        ("imu/accel=bias:1@x", ["want SENSOR=KIND"]),
        ("imu/accel=teeth:44", ["wheel/WHEEL"]),
        ("imu/accel=swap", ["sensor of a wheel"]),
        ("wheel/fl=teeth:1", ["'1'", "2 to 1000"]),
    ],
)
def test_what_is_no_fault_is_refused_in_one_line(text: str, names: list[str]) -> None:
    with pytest.raises(ValueError) as refused:  # noqa: PT011  the lines are compared below
        parse_fault(text)
    said = str(refused.value)
    assert repr(text) in said
    assert "\n" not in said
    assert all(name in said for name in names)


def test_truth_tells_each_fault_once_and_what_the_sound_sensor_says() -> None:
    faults = [parse_fault(text) for text in ("imu/accel/x=bias:0.3@2-4", "wheel/rr=stuck@3")]
    told: dict[str, list[tuple[float, str]]] = {}
    sound: Mapping[str, Signal] = {}
    for start in np.arange(0.0, SECONDS, 0.5):
        for name, signal in fault_events(faults, start, start + 0.5).items():
            told.setdefault(name, []).extend(zip(signal.time.tolist(), signal.value, strict=True))
        if start == 2.5:
            sound = sound_signals(faults, {n: s.between(start, start + 0.5) for n, s in log().items()})
    assert told == {"truth/fault/imu/accel/x": [(2.0, "bias:0.3"), (4.0, "")], "truth/fault/wheel/rr": [(3.0, "stuck")]}
    assert set(sound) == {"truth/sound/imu/accel"}
    assert sound["truth/sound/imu/accel"] == log()["imu/accel"].between(2.5, 3.0)
