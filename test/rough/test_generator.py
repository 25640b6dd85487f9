"""The generator keeps its promises: alone, the same again, of all sizes, every twin, and true to its strengths."""

import ast
from pathlib import Path

import numpy as np
import pytest

from test.rough import rig as rigs
from test.rough import sensors
from test.rough.case import RoughError, left, make_case, rest_of, simulated
from test.rough.device import FORCE_LATE, FORCE_SLOW, ZERO
from test.rough.drives import MOTIONS, POOR, draw_drive, reach
from test.rough.generator import main
from test.rough.names import BESIDE, RIGHT
from test.rough.plan import COUNT, KINDS, TWINS, Asked, combinations, of_seed, plan
from test.rough.rig import DEVICES, RATES, draw_rig
from test.rough.sensors import Wrong
from test.rough.truths import TRUTHS, scale_of, stronger, table

pytestmark = pytest.mark.slow

HERE = Path(__file__).parent
ALONE = {"__future__", "numpy", "scipy", "numba", "pyarrow", "test.rough"}
STANDARD = {
    "argparse", "collections.abc", "dataclasses", "json", "math", "pathlib", "sys", "typing", "zlib",
}  # fmt: skip


def imported(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield f"{'.' * node.level}{node.module}"


def test_it_shares_nothing_with_the_lab_or_the_other_generator():
    files = [p for p in HERE.glob("*.py") if not p.name.startswith("test_")]
    found = {n for p in files for n in imported(p)} - STANDARD
    assert len(files) > 8
    assert {
        n if n in STANDARD else ".".join(n.split(".")[: 1 + n.startswith("test.")]) for n in found
    } <= ALONE
    scorer = {n for p in (HERE.parent / "rough_score").glob("*.py") for n in imported(p)}
    assert not [n for n in scorer if n.startswith("test.blind.")]


@pytest.fixture
def short(monkeypatch):
    """Records of 4 s on a coarse grid."""
    for name, value in (
        ("SHORTEST", 4.0), ("LONGEST", 4.0), ("FINEST", 1000.0), ("SAMPLES", 1000.0),
        ("RATES", (200.0, 250.0, 1000.0)), ("OFTEN", (0.5, 0.4, 0.1)),
    ):  # fmt: skip
        monkeypatch.setattr(rigs, name, value)


@pytest.mark.parametrize("twin", TWINS)
def test_every_twin_is_made_in_both_sizes(twin, short, tmp_path):
    asked = [a for a in of_seed(3) if a.twin == twin]
    assert len(asked) == 2
    small, large = sorted(
        (make_case(a, tmp_path / a.size) for a in asked), key=lambda c: c.rig.force
    )
    assert 40.0 <= small.rig.force <= 400.0
    assert 2e3 <= large.rig.force <= 20e3
    assert len(small.shown) == len(TWINS[twin].truths)
    assert small.wrong[0].wild == TWINS[twin].wild
    assert small.drives[0].rest >= TWINS[twin].rest
    assert all(
        (c.folder / "model.yaml").exists() and (c.fresh / "record_1.csv").exists()
        for c in (small, large)
    )


def files(folder):
    return {
        p.relative_to(folder): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()
    }


def test_a_case_is_the_same_again_and_another_by_its_seed(short, tmp_path):
    asked = Asked("single", "er", ("coulomb",), 5, 0)
    for name in ("one", "again"):
        make_case(asked, tmp_path / name)
    assert files(tmp_path / "one") == files(tmp_path / "again")
    make_case(Asked("single", "er", ("coulomb",), 6, 0), tmp_path / "other")
    assert (tmp_path / "other/model.yaml").read_bytes() != (
        tmp_path / "one/model.yaml"
    ).read_bytes()
    with pytest.raises(RoughError, match="found data"):
        make_case(asked, tmp_path / "one")


def test_sizes_and_rates_are_spread_as_stated():
    rng = np.random.default_rng(0)
    drawn = [draw_rig(DEVICES[k % 5], rng) for k in range(600)]
    assert {r.rate for r in drawn} == set(RATES)
    assert {r.sensors for r in drawn} == set(rigs.CHANNELS)
    assert {r.records for r in drawn} == {1, 2, 3}
    for values, (low, high) in (
        ([r.force for r in drawn], rigs.FORCES), ([2.0 * r.stroke for r in drawn], rigs.STROKES),
    ):  # fmt: skip
        tenths = np.quantile(np.log(values), [0.0, 0.5, 1.0])
        assert low <= np.exp(tenths[0]) < 1.2 * low
        assert high / 1.2 < np.exp(tenths[2]) <= high
        assert tenths[1] == pytest.approx(0.5 * np.log(low * high), abs=0.4)
    assert all(15.0 <= r.seconds <= 30.0 and r.rate >= 36.0 * r.frequency - 1e-9 for r in drawn)
    assert all((r.count > 0.0) == (r.sensors == "encoder") for r in drawn)


def test_a_seed_holds_150_cases_of_all_kinds_from_its_beginning():
    cases = of_seed(1)
    assert len({a.key for a in cases}) == len(cases) == 150
    assert {k: sum(a.kind == k for a in cases) for k in KINDS} == COUNT
    assert {a.kind for a in cases[:40]} == set(KINDS)
    assert {a.device for a in cases} == set(DEVICES)
    assert (
        {t for s in range(1, 4) for a in of_seed(s) for t in a.truths} == set(TRUTHS) == set(RIGHT)
    )
    assert set(BESIDE) <= set(RIGHT)
    assert of_seed(2) != cases
    assert plan(["twin"], [1], cases=3) == [a for a in cases if a.kind == "twin"][:3]


@pytest.mark.parametrize("name", [*MOTIONS, *POOR])
@pytest.mark.parametrize("rest", [False, True])
def test_motions_are_smooth_within_the_rig_and_begin_as_stated(name, rest):
    rig = draw_rig("mr", np.random.default_rng(3), rate=200.0)
    drive = draw_drive(rig, np.random.default_rng(1), name, "steps", rest=rest)
    h = 1.0 / rig.fine
    assert np.abs(drive.x).max() <= rig.stroke * 1.0001
    assert np.abs(drive.v).max() <= rig.velocity * 1.0001
    assert max(np.abs(drive.x).max() / rig.stroke, np.abs(drive.v).max() / rig.velocity) > 0.999
    assert np.abs(np.diff(drive.v)).max() < 0.02 * rig.velocity  # no jump
    way = np.cumsum(0.5 * h * (drive.v[1:] + drive.v[:-1]))
    np.testing.assert_allclose(way, drive.x[1:] - drive.x[0], atol=1e-4 * rig.stroke)
    began = np.abs(drive.v[drive.lead : drive.lead + round(0.5 * rig.fine)]).max()
    assert (began == 0.0) == rest or name in ("moves", "earthquake")
    inside = drive.u[drive.lead :]
    assert np.all(inside.reshape(-1, rig.every) == inside[:: rig.every, None])  # held for a sample


@pytest.mark.parametrize("name", MOTIONS)
def test_a_fresh_drive_stays_within_what_was_learnt_from(name):
    rig = draw_rig("mr", np.random.default_rng(3), rate=200.0)
    learnt = [
        draw_drive(rig, np.random.default_rng(k), "moves", "steps", rest=True) for k in (0, 1)
    ]
    new = draw_drive(rig, np.random.default_rng(5), name, "steps", rest=True, within=learnt)
    for signal in ("x", "v"):
        (low, high), (least, most) = reach(signal, learnt), reach(signal, [new])
        assert low < least < most < high
    (low, high), (least, most) = reach("x", learnt), reach("x", [new])
    assert most - least > 0.3 * (high - low)  # and is no standstill


def quick(**changes):
    rig = draw_rig("er", np.random.default_rng(7), rate=200.0, sensors="full")
    drive = draw_drive(rig, np.random.default_rng(2), "noise", "steps", rest=False)
    return rig, drive


def columns_of(rig, drive, rows=None):
    laws = table(rows or {})
    return laws, sensors.clean(rig, drive, simulated(rig, drive, laws), laws)


def test_wild_samples_bent_ends_and_missing_channels():
    rig, drive = quick()
    _, clean = columns_of(rig, drive)
    plain = sensors.measured(rig, clean, Wrong(), np.random.default_rng(0))
    noise = plain["damper_force"] - clean["damper_force"]
    assert noise.std() == pytest.approx(rig.noise[0], rel=0.1)
    seen = {}
    for wild, name in (
        ("outliers", "damper_force"),
        ("spike", "unsprung_acceleration"),
        ("clip", "damper_force"),
    ):
        bad = sensors.measured(rig, clean, Wrong(wild=wild), np.random.default_rng(0))
        seen[wild] = np.flatnonzero(bad[name] != plain[name])
    assert seen["outliers"].size == round(0.003 * rig.n)
    assert seen["spike"].size == 1
    assert seen["clip"].size == pytest.approx(0.4 * rig.rate, abs=1.0)
    bent = sensors.measured(rig, clean, Wrong(bent=True), np.random.default_rng(0))
    assert set(np.flatnonzero(bent["deflection"] != plain["deflection"])) == {
        *range(3),
        *range(rig.n - 3, rig.n),
    }
    fewer = draw_rig("passive", np.random.default_rng(7), sensors="encoder")
    still = draw_drive(fewer, np.random.default_rng(2), "noise", "steps", rest=False)
    found = sensors.measured(fewer, columns_of(fewer, still)[1], Wrong(), np.random.default_rng(0))
    assert set(found) == {"t", "deflection", "damper_force"}
    steps = found["deflection"] / fewer.count
    np.testing.assert_allclose(steps, np.round(steps), atol=1e-6)


def test_sensors_shift_lag_and_delay():
    rig, drive = quick()
    _, plain = columns_of(rig, drive)
    _, moved = columns_of(rig, drive, {ZERO: (1e-3,)})
    np.testing.assert_allclose(moved["deflection"] - plain["deflection"], 1e-3)
    late = sensors.channel_force(np.arange(1000.0), table({FORCE_LATE: (0.01,)}), 1e-3)
    assert late[500] == pytest.approx(490.0)
    slow = sensors.channel_force(np.arange(1000.0), table({FORCE_SLOW: (0.02,)}), 1e-3)
    assert slow[900] == pytest.approx(900.0 - 25.0, rel=1e-6)  # poles of 20 and 5 ms


def test_what_the_truth_leaves_is_little_more_than_the_noise():
    rig, drive = quick()
    laws, clean = columns_of(rig, drive)
    noisy = sensors.measured(rig, clean, Wrong(), np.random.default_rng(0))
    assert 1.0 <= left(rig, drive, laws, clean, noisy) / rig.noise[0] < 1.5
    assert rest_of(rig, drive, laws) < 1e-6 * rig.force


def test_every_truth_shows_on_every_device_that_may_have_it(short):
    for device in DEVICES:
        rng = np.random.default_rng(11)
        rig = draw_rig(device, rng, rate=250.0)
        drives = [draw_drive(rig, rng, m, "steps", rest=False) for m in ("sines", "sweep")]
        for name in (t for d, t in combinations() if d == device):
            rows = TRUTHS[name].draw(rng, scale_of(rig))
            laws = table(stronger(TRUTHS[name], rows, 3.0))
            shown = [rest_of(rig, drive, laws) for drive in drives]
            assert max(shown) > 1e-4 * rig.force, (device, name)


def test_the_command_line(short, tmp_path, capsys):
    assert main(["--seed", "1", "--list"]) == 0
    assert len(capsys.readouterr().out.splitlines()) == 150
    assert main(["--case", "complete/passive", "--out", str(tmp_path / "c")]) == 0
    assert capsys.readouterr().out.startswith("complete/passive/nothing/1/")
    assert main(["--case", "complete/passive", "--out", str(tmp_path / "c")]) == 2
    assert main(["--case", "nobody", "--out", str(tmp_path / "d")]) == 2
