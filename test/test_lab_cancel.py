"""A search that is watched and stopped: who is ahead is told early, and `cancel` ends it within a second."""

import threading
import time
from contextlib import suppress

import pytest
from er_model_lab.diagnosis.ranking import TRYING

import er_model_lab as lab
from test.sample import with_friction, write_ride, write_sample

WITHIN = 1.0
"""Time in which a call ends once its `cancel` is set [s]."""


@pytest.fixture(scope="module")
def minute(tmp_path_factory):
    """A minute of data with two effects that are found one after the other."""
    truth = with_friction("inove_guo").with_effect("preload", {"F_0": 4.0})
    file = tmp_path_factory.mktemp("minute") / "run.csv"
    return lab.load(write_sample(file, seed=4, seconds=60.0, truth=truth))


class Watch:
    """Progress that sets the event a while after a job of a stage, in its first or a later round."""

    def __init__(self, stage, nth, after=0.2):
        self.stop, self.wanted, self.after = threading.Event(), (stage, nth), after
        self.told, self.rounds, self.set_at = [], 0, None

    def __call__(self, stage, done, total, best):
        self.told.append((time.monotonic(), stage, done, total, best))
        self.rounds += (stage, done) == (self.wanted[0], 1)
        if (stage, self.rounds) == self.wanted and done == 2:
            threading.Timer(self.after, self._set).start()

    def _set(self):
        self.set_at = time.monotonic()
        self.stop.set()

    @property
    def late(self):
        """Time since the event was set [s]."""
        return time.monotonic() - self.set_at


@pytest.mark.slow
@pytest.mark.alone
def test_a_diagnosis_of_a_minute_keeps_what_it_found(minute):
    watch = Watch(TRYING, 2)
    model = lab.load_model("inove_guo")
    result = lab.diagnose(minute, model, progress=watch, cancel=watch.stop)
    assert watch.late < WITHIN
    assert result.interrupted
    assert list(result.effects) == ["preload"]
    assert result.model.value("preload", "F_0") == pytest.approx(4.0, abs=0.5)
    assert "preload" in result.to_dict()["effects"]


@pytest.mark.slow
@pytest.mark.alone
def test_before_it_found_anything_it_says_so(minute):
    watch = Watch(TRYING, 1)
    with pytest.raises(lab.Cancelled):
        lab.diagnose(minute, lab.load_model("inove_guo"), progress=watch, cancel=watch.stop)
    assert watch.late < WITHIN


@pytest.mark.slow
@pytest.mark.alone
@pytest.mark.parametrize("after", [0.5, 8.0])
def test_so_does_that_of_a_car(tmp_path, after):
    data = lab.load(write_ride(tmp_path / "ride.csv", seed=1, seconds=60.0))
    stop, at = threading.Event(), []

    def end():
        at.append(time.monotonic())
        stop.set()

    threading.Timer(after, end).start()
    with suppress(lab.Cancelled):
        lab.diagnose(data, lab.load_model("inove_quarter_car"), level="vehicle", cancel=stop)
    assert time.monotonic() - at[0] < WITHIN


@pytest.mark.slow
def test_who_is_ahead_is_told_within_a_third_of_the_time(tmp_path):
    watch = Watch("", 0)
    data = lab.load(write_sample(tmp_path / "run.csv", seed=4, truth=with_friction("inove_guo")))
    began = time.monotonic()
    result = lab.diagnose(data, lab.load_model("inove_guo"), progress=watch)
    whole = time.monotonic() - began
    first = next(at for at, *_, best in watch.told if best)
    assert first - began < whole / 3.0
    assert not result.interrupted
    last = watch.told[-1][-1]
    assert [leader.rmse for leader in last] == sorted(leader.rmse for leader in last)
    assert isinstance(last[0], lab.Leader)
    for (_, stage, done, *_), (_, later, more, *_) in zip(
        watch.told, watch.told[1:], strict=False
    ):
        assert stage != later or more == done + 1 or more == 1
