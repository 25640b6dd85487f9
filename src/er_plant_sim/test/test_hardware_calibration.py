"""Calibration files and what they do to counts."""

import math
from pathlib import Path

import pytest
from er_models.errors import InputError
from er_plant_sim.hardware import calibration
from er_plant_sim.hardware.calibration import EMPTY, Calibration, Channel, Quality
from er_plant_sim.hardware.frame import CHANNELS

ROOT = Path(__file__).resolve().parents[3]


def test_gain_offset_and_sign_by_hand() -> None:
    channel = Channel(gain=2e-6, offset=120.0, sign=-1.0, low=-1000.0, high=1000.0)
    assert calibration.to_si(channel, 620) == pytest.approx(-1e-3)
    assert calibration.to_counts(channel, -1e-3) == 620
    assert calibration.to_counts(channel, -1.0) == 1000


def test_every_channel_says_what_it_is_worth() -> None:
    p = Calibration("x", (Channel(1.0), Channel(1.0, low=-5.0, high=5.0), None, Channel(1.0)))
    _, values = calibration.step(p, EMPTY, (3, 6, 1, 2), 0b0111, 0.005)
    assert [v.quality for v in values] == [
        Quality.OK, Quality.OUT_OF_RANGE, Quality.ABSENT, Quality.UNREAD,
    ]  # fmt: skip
    assert [v.value for v in values] == [3.0, 0.0, 0.0, 0.0]


def test_the_low_pass_follows_a_step_as_its_equation_says() -> None:
    p = Calibration("x", (Channel(1.0, cutoff=10.0),))
    state, _ = calibration.step(p, EMPTY, (0,), 1, 0.005)
    for _ in range(4):
        state, ((value, _),) = calibration.step(p, state, (1,), 1, 0.005)
    assert value == pytest.approx(1.0 - math.exp(-2.0 * math.pi * 10.0 * 0.02))


def test_the_calibration_that_is_shipped_covers_every_channel() -> None:
    found = calibration.load_calibration(ROOT / "config/hardware/device_emulator.yaml")
    assert len(found.channels) == len(CHANNELS)
    assert all(found.channels)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("channels: {force: {gain: 1}}", "schema: expected 'er_calibration 1', found nothing"),
        ("schema: er_calibration 1", "channels: expected a mapping of sprung_acceleration"),
        ("{c}: {{forse: {{gain: 1}}}}", "channels.forse: expected one of .*found an unknown key"),
        ("{c}: {{force: {{}}}}", "channels.force.gain: expected N per count, found nothing"),
        ("{c}: {{force: {{gain: 0}}}}", "channels.force.gain: expected 1e-15 to 1e"),
        ("{c}: {{force: {{gain: 1, sign: 0.5}}}}", "channels.force.sign: expected 1 or -1, found"),
        ("{c}: {{force: {{gain: 1, low: 5, high: 1}}}}", "channels.force.low: expected a reading"),
        ("{c}: {{force: {{gain: 1, ofset: 3}}}}", "force.ofset: .*did you mean offset"),
    ],
)
def test_a_bad_file_is_one_line(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "rig.yaml"
    path.write_text(text.format(c="schema: er_calibration 1\nchannels") if "{c}" in text else text)
    with pytest.raises(InputError, match=words) as caught:
        calibration.load_calibration(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)
