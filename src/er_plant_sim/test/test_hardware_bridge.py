"""Bridge and device over a wire that exists in the test only, in a time of the test's own."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from er_common.parameter_table import build as checked
from er_models.errors import InputError
from er_models.files import load_model
from er_models.interlude import GO_OVER
from er_models.program import load_program
from er_plant_sim.duty_gate import BURST, Command, Gate, Reason
from er_plant_sim.hardware import bridge, clocks, device, frame, impair, parser
from er_plant_sim.hardware.bridge import Bridge, BridgeState, Reading, Sources
from er_plant_sim.hardware.calibration import Quality, load_calibration
from er_plant_sim.hardware.clocks import ClockState, Exchange
from er_plant_sim.hardware.device import Device, DeviceState
from er_plant_sim.hardware.frame import Sample
from er_plant_sim.hardware.impair import Wire, WireState
from er_plant_sim.hardware.parser import ParserState
from er_plant_sim.hardware.settings import BridgeParameters, build, signals, with_planned
from er_plant_sim.noise import PERFECT, Noise
from er_plant_sim.rig import Rig
from er_plant_sim.simulator import simulator

from er_plant_sim import rig as plant

CONFIG = Path(__file__).resolve().parents[3] / "config"
CALIBRATION = load_calibration(CONFIG / "hardware/device_emulator.yaml")
PERIOD, MS = 5_000_000, 1_000_000
NOMINAL = 2


def rig(watchdog: float = 0.05) -> Rig:
    """A quarter car without noise on the identification road."""
    model = load_model(CONFIG / "vehicles/inove_quarter_car.yaml")
    program = load_program(CONFIG / "experiments/step.yaml")
    gate = Gate(0.0, 0.3, 0.1, watchdog)
    return Rig(simulator(model, 0.005, Noise(PERFECT, PERFECT, 0)), gate, program, False)


RIG = rig()


def host(**changes: object) -> Bridge:
    """A bridge whose own limits are tighter than the device's."""
    gate = Gate(0.0, 0.25, 0.1, 0.05)
    return replace(Bridge(CALIBRATION, gate, PERIOD, 0.05, Sources(1, 4)), **changes)


@dataclass
class World:
    """Host, device and wire; the device's clock is 30 ppm fast and began elsewhere."""

    p: Bridge
    wire: Wire = field(default_factory=Wire)
    answer: Callable[[Reading], float | None] = lambda _: 0.2
    now: int = 10_000_000_000
    d: Device = field(default_factory=lambda: Device(RIG, CALIBRATION, 1))
    readings: list[Reading] = field(default_factory=list)
    silences: int = 0

    def __post_init__(self) -> None:
        self.host: BridgeState = bridge.start(self.p, self.now)
        self.device: DeviceState = device.start(self.d)
        self.ways = [WireState(), WireState(given=1 << 40)]
        self.queues: list[list[tuple[int, bytes]]] = [[], []]
        self.truth: list[plant.Measurement] = []

    def own(self) -> int:
        """Time on the device's clock [ns]."""
        return round(1.00003 * self.now) - 9_000_000_000

    def run(self, seconds: float, *, ticking: bool = True) -> None:
        """Let time pass in steps of 1 ms."""
        for _ in range(round(1000 * seconds)):
            self.now += MS
            if ticking and self.now % PERIOD == 0:
                self.device, data = device.tick(self.d, self.device, self.own())
                self.truth.append(plant.sense(RIG, self.device.rig))
                self.post(0, data)
            self.host, said = bridge.on_time(self.p, self.host, self.now)
            self.silences += said.silence
            self.post(1, said.data)
            for data in self.due(1):
                self.device, answer = device.on_bytes(self.d, self.device, data, self.own())
                self.post(0, answer)
            for data in self.due(0):
                self.heard(data)

    def heard(self, data: bytes) -> None:
        self.host, said = bridge.on_bytes(self.p, self.host, data, self.now)
        self.post(1, said.data)
        for reading in said.readings:
            self.readings.append(reading)
            duty = self.answer(reading)
            if duty is not None:
                wish = Command(0.0, reading.seq, duty, NOMINAL)
                self.host, data = bridge.on_command(self.p, self.host, wish, self.now, valid=True)
                self.post(1, data)

    def post(self, way: int, data: bytes) -> None:
        if data:
            self.ways[way], out = impair.step(self.wire, self.ways[way], data, self.now)
            self.queues[way] += [out] if out else []

    def due(self, way: int) -> list[bytes]:
        ready = [data for when, data in self.queues[way] if when <= self.now]
        self.queues[way] = [each for each in self.queues[way] if each[0] > self.now]
        return ready

    def begin(self) -> World:
        """Run until the bridge would begin, and begin."""
        self.run(1.5)
        assert bridge.refusal(self.p, self.host) == ""
        self.host = bridge.begin(self.host)
        return self


def test_readings_are_what_the_rig_measured_to_half_a_count() -> None:
    world = World(host()).begin()
    first = len(world.truth)
    world.run(1.0)
    assert [r.seq for r in world.readings] == list(range(1, 201))
    for reading, m in zip(world.readings, world.truth[first:], strict=True):
        true = (*m[2:7], m.road)
        for value, expected, channel in zip(
            reading.values, true, CALIBRATION.channels, strict=True
        ):
            assert value.quality is Quality.OK
            assert channel is not None
            assert value.value == pytest.approx(expected, abs=0.5000001 * channel.gain)


def test_stamps_are_the_time_of_the_measurement_on_the_hosts_clock() -> None:
    world = World(host(), Wire(jitter=0.002, seed=3)).begin()
    began = world.now
    world.run(2.0)
    stamps = np.array([r.stamp for r in world.readings])
    assert len(stamps) > 390
    numbers = np.arange(len(stamps)) + round((stamps[0] - began) / PERIOD)  # one may be on its way
    error = stamps - (began + PERIOD * numbers)
    # 2 ms of jitter each way, and ticks of 1 ms in which this test hears
    assert np.abs(error).max() < 0.5 * MS


def test_the_duty_answers_the_sample_before_and_both_sides_limit_it() -> None:
    world = World(host(), answer=lambda r: (0.2, 0.28, 0.9)[r.seq % 3]).begin()
    world.run(0.5)
    for reading in world.readings[5:]:
        applied = reading.applied
        assert applied.reason is Reason.COMMAND
        assert applied.command_seq == reading.seq - 1
        wish = (0.2, 0.28, 0.9)[applied.command_seq % 3]
        assert applied.duty == pytest.approx(min(wish, 0.25))
        assert applied.saturated == (wish > 0.25)
        assert applied.source == NOMINAL


def test_without_commands_the_host_asks_for_the_safe_duty_within_the_timeout() -> None:
    # a device whose own watchdog would not notice
    patient = Device(rig(watchdog=100.0), CALIBRATION, 1)
    world = World(host(), answer=lambda r: 0.2 if r.seq < 100 else None, d=patient).begin()
    world.run(1.0)
    reasons = [r.applied.reason for r in world.readings]
    assert reasons[20:98] == [Reason.COMMAND] * 78
    last = world.readings[98].stamp  # the sample that was answered last
    late = [r for r in world.readings if r.stamp > last + 60 * MS]
    assert {r.applied.reason for r in late} == {Reason.OLD_COMMAND}
    assert {r.applied.duty for r in late} == {0.1}


def test_without_the_host_the_device_falls_back_by_itself() -> None:
    world = World(host()).begin()
    world.run(0.5)
    assert world.device.rig.gate.duty == pytest.approx(0.2)
    world.ways[1] = WireState()
    for _ in range(12):  # 60 ms: nobody listens any more
        world.now += PERIOD
        world.device, data = device.tick(world.d, world.device, world.own())
    assert world.device.rig.gate.duty == 0.1
    _, found = parser.step(ParserState(), data)
    sample = found[-1].message
    assert isinstance(sample, Sample)
    assert sample.flags == frame.WATCHDOG


def test_a_silent_device_is_said_once_and_found_again() -> None:
    world = World(host()).begin()
    world.run(0.5)
    world.run(0.3, ticking=False)
    assert world.silences == 1
    count = len(world.readings)
    world.run(0.3)
    assert world.silences == 1
    assert len(world.readings) >= count + 59
    stamps = [r.stamp for r in world.readings]
    assert stamps == sorted(set(stamps))


def test_samples_that_were_only_held_up_are_newer_than_the_word_that_they_stay_away() -> None:
    world = World(host()).begin()
    world.run(0.5)
    held: list[bytes] = []
    world.heard, hear = held.append, world.heard  # type: ignore[method-assign]
    world.run(0.2)
    assert world.silences == 1
    said = world.host.stamp
    for data in held:
        hear(data)
    after = [r.stamp for r in world.readings if r.seq > 100]
    assert len(after) == 40
    assert min(after) > said


def test_a_device_that_restarts_goes_on_after_its_clock_was_aligned() -> None:
    world = World(host()).begin()
    world.run(0.5)
    before = world.readings[-1].seq
    world.d = Device(RIG, CALIBRATION, 2)
    world.device, world.now = device.start(world.d), world.now + 700 * MS
    world.run(1.5)
    assert world.host.boots == 1
    assert world.host.clock.restarts >= 1
    assert [r.seq for r in world.readings] == list(range(1, len(world.readings) + 1))
    assert world.readings[-1].seq > before + 200
    assert abs(world.readings[-1].stamp - world.now) < 10 * MS


def test_a_bridge_that_is_started_again_is_obeyed_by_a_device_that_drops_old_frames() -> None:
    world = World(host()).begin()
    world.host = world.host._replace(sent=1_000_000)  # it has run for long
    world.run(0.1)
    world.host, world.readings = bridge.start(world.p, world.now), []
    world.begin()
    world.run(0.2)
    assert {r.applied.reason for r in world.readings[5:]} == {Reason.COMMAND}
    assert {r.applied.duty for r in world.readings[5:]} == {0.2}


def test_a_bridge_that_was_at_rest_is_obeyed_at_once() -> None:
    world = World(host()).begin()
    world.run(0.5)
    world.host, data = bridge.farewell(world.p, world.host)
    world.post(1, data)
    world.host = bridge.start(world.p, world.now, sent=world.host.sent)
    world.run(0.1)
    assert world.host.clock.exchanges > 0


def test_a_device_drops_what_is_not_newer_until_it_forgets_the_hosts_number() -> None:
    d = Device(RIG, CALIBRATION, 1)
    state = device.start(d)

    def answered(seq: int, now: int) -> bool:
        nonlocal state
        state, data = device.on_bytes(d, state, frame.encode(frame.Sync(1), seq), now)
        return bool(data)

    top = frame.WRAP - 1
    heard = [answered(seq, MS * k) for k, seq in enumerate((top - 1, top - 1, top, 0, top, 1))]
    assert heard == [True, False, True, True, False, True]
    late = 5 * MS + device.FORGOTTEN
    # what was dropped does not keep the number alive
    assert [answered(1, late), answered(1, late + 1)] == [False, True]


def test_a_bad_wire_loses_samples_but_never_delivers_a_wrong_one() -> None:
    wire = Wire(loss=0.05, corruption=0.1, jitter=0.001, ordered=False, seed=5)
    world = World(host(), wire).begin()
    began, first = world.now, len(world.truth)
    world.run(5.0)
    seqs = [r.seq for r in world.readings]
    assert seqs == sorted(set(seqs))
    assert 0.7 < len(seqs) / (len(world.truth) - first) < 0.95
    channel = CALIBRATION.channels[2]
    assert channel is not None
    for reading in world.readings:
        true = world.truth[first + round((reading.stamp - began) / PERIOD) - 1]
        shown = reading.values[2].value
        assert shown == pytest.approx(true.deflection, abs=0.5000001 * channel.gain)
    assert world.host.parser.damaged > 20
    assert world.host.missed == seqs[-1] - len(seqs) - (seqs[0] - 1)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"period": 10_000_000}, "the device samples at 200 Hz, parameter rate expects 100 Hz"),
        ({"certain": 1e-9}, "the clocks are not aligned yet"),
    ],
)
def test_what_does_not_fit_is_refused_with_a_reason(change: dict[str, object], words: str) -> None:
    world = World(host(**change))
    world.run(1.5)
    world.host = bridge.begin(world.host)
    world.run(0.2)
    assert bridge.refusal(world.p, world.host) == words
    assert world.readings == []


def test_a_device_that_no_longer_tells_its_time_is_refused_until_it_does_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    world = World(host(unanswered=400 * MS)).begin()
    world.run(0.2)
    with monkeypatch.context() as deaf:
        deaf.setattr(device, "on_bytes", without_replies(device.on_bytes))
        world.run(0.3)
        assert bridge.refusal(world.p, world.host) == ""
        world.run(0.4)
        count = len(world.readings)
        assert bridge.refusal(world.p, world.host) == "the device has not told its time for 0.4 s"
        world.run(0.1)
        assert len(world.readings) == count
    world.run(0.2)
    assert bridge.refusal(world.p, world.host) == ""
    assert len(world.readings) > count + 30


def without_replies(takes: Any) -> Any:
    """A device that takes bytes like this one, but does not say a word on that."""
    return lambda *given: (takes(*given)[0], b"")


def test_clocks_that_were_compared_once_are_not_aligned_for_long() -> None:
    p = host()
    once = clocks.step(p.clock, ClockState(), Exchange(0, 7 * MS, 7 * MS, MS))  # 0.5 ms
    state = BridgeState(clock=once, answered_at=MS)
    for seconds, aligned in ((0.1, True), (3.0, True), (4.9, False)):
        later = state._replace(asked_at=round(1e9 * seconds))
        assert bridge.aligned(p, later) == aligned


def test_a_device_that_cannot_move_the_road_is_refused_where_it_should() -> None:
    for road, words in ((lambda _: 0.0, "the device cannot move the road"), (None, "")):
        world = World(host(road=road))
        world.run(0.5)
        assert bridge.refusal(world.p, world.host) == ""
        world.heard(frame.encode(world.d.hello._replace(abilities=0), 1))
        assert bridge.refusal(world.p, world.host).startswith(words)
        assert bool(bridge.refusal(world.p, world.host)) == bool(words)


def test_the_road_and_duty_of_a_program_reach_the_device() -> None:
    p = host(duty=lambda tick: 0.05 + 0.1 * (tick % 2), road=lambda tick: 1e-3 * (tick % 7))
    world = World(p).begin()
    world.run(0.5)
    assert {r.applied.reason for r in world.readings[5:]} == {Reason.PROGRAM}
    for reading in world.readings[5:]:
        assert reading.applied.duty == pytest.approx(0.05 + 0.1 * (reading.seq % 2))
        assert reading.values[5].value == pytest.approx(1e-3 * (reading.seq % 7), abs=1e-6)


def test_a_height_that_the_wire_cannot_carry_goes_as_far_as_it_can() -> None:
    assert [frame.from_height(1e-9 * h) for h in (-3e9, -1.0, 2.6, 3e9)] == [
        -frame.ROAD_REACH, -1, 3, frame.ROAD_REACH
    ]  # fmt: skip
    world = World(host(road=lambda _: 1e3)).begin()
    world.run(0.05)
    assert world.device.height == pytest.approx(2.147483647, abs=1e-9)


def test_a_program_whose_road_the_wire_cannot_carry_is_one_line(tmp_path: Path) -> None:
    path = tmp_path / "high.yaml"
    given: dict[str, object] = {
        "model_file": str(CONFIG / "vehicles/inove_quarter_car.yaml"), "safe_duty": 0.1, "link": "udp:h:1",
        "calibration_file": str(CONFIG / "hardware/device_emulator.yaml"), "program_file": str(path),
    }  # fmt: skip

    def made(height: float, source: str) -> Bridge:
        path.write_text(
            "schema: er_program 1\nduration: 2.0\nduty: {kind: constant, level: 0.1}\n"
            f"road: {{kind: step, height: 1.0, factor: {height}, time: 1.0, rise: 0.01}}\n"
        )
        p = checked(BridgeParameters, given | {"road_source": source}, {})
        return build(p, Sources(1, 4)).bridge

    assert made(3.0, "device").road is None
    road = made(2.1, "program").road
    assert road is not None
    assert road(399) == pytest.approx(2.1)
    with pytest.raises(InputError, match=r"high.yaml: road: expected .*2.147 m.* found 3 m"):
        made(3.0, "program")


@pytest.mark.parametrize("source", ["program", "device"])
def test_a_planned_run_says_duty_and_road_for_as_long_as_it_takes(
    source: str, tmp_path: Path
) -> None:
    path = tmp_path / "run.yaml"
    path.write_text(
        "schema: er_program 1\nduration: 0.3\nduty: {kind: constant, level: 0.15}\n"
        "road: {kind: sine, amplitude: 0.002, frequency: 5.0}\n"
    )
    p = checked(
        BridgeParameters,
        {
            "model_file": str(CONFIG / "vehicles/inove_quarter_car.yaml"),
            "calibration_file": str(CONFIG / "hardware/device_emulator.yaml"),
            "program_file": str(CONFIG / "experiments/step.yaml"),
            "planned_file": str(path),
            "link": "udp:h:1",
            "safe_duty": 0.1,
            "road_source": source,
        },
        {},
    )
    drive = with_planned(p, build(p, Sources(1, 4)).drive, 40)
    duty, road = signals(p, drive, 40)
    world = World(host(duty=duty, road=road)).begin()
    world.run(1.7)
    ruled = [r for r in world.readings if r.applied.reason is Reason.PROGRAM]
    first = 40 + round(GO_OVER / 0.005)
    assert [r.seq for r in ruled] == list(range(first, first + 60))
    assert {round(r.applied.duty, 3) for r in ruled} == {0.15}
    others = [r for r in world.readings[50:] if r not in ruled]
    assert {r.applied.reason for r in others} == {Reason.COMMAND}, "commands are taken meanwhile"
    assert (world.host.gate.refused, road is None) == (0, source == "device")
    if road is not None:
        assert ruled[10].values[5].value == pytest.approx(0.002, abs=1e-5)
        assert road(first + 60 + 200) == 0.01, "the drive goes on where it is by then"


def test_a_wire_named_wrongly_is_one_line() -> None:
    from er_plant_sim.hardware.link import Address

    for text in ("serial:", "udp:host", "udp:host:99999", "serial:x@fast", "can:0", "tty"):
        with pytest.raises(InputError, match=r"expected .*found"):
            Address(text, ("serial", "udp"))
    assert Address("udp:10.0.0.2:5005", ("udp",)).number == 5005
    assert Address("serial:/dev/ttyS0@9600", ("serial",)).number == 9600
    assert frame.VERSION == 1


def test_a_command_without_a_number_is_as_old_as_its_stamp() -> None:
    world = World(host(), answer=lambda _: None).begin()
    world.run(0.2)
    for age, reason in ((10, Reason.COMMAND), (60, Reason.OLD_COMMAND)):
        wish = Command(0.0, 0, 0.25, NOMINAL)
        stamp = world.now - age * MS
        world.host, _ = bridge.on_command(
            world.p, world.host, wish, world.now, valid=True, stamp=stamp
        )
        assert world.host.reason is reason


def test_a_second_controller_that_writes_no_number_is_counted_as_one() -> None:
    world = World(host()).begin()
    for _ in range(40):
        world.run(0.005)
        world.host, _ = bridge.on_command(
            world.p, world.host, Command(0.0, 0, 0.25, NOMINAL), world.now, valid=True
        )
    assert world.host.gate.repeated >= 40 - BURST
