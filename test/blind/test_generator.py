"""The generator's files, noise, seeds and command line are as stated."""

from __future__ import annotations

import ast
import json
from pathlib import Path

import numpy as np
import pytest

from test.blind.catalogue import BY_NAME, EVERY, INSIDE, N_EFFECTS, OUTSIDE
from test.blind.effect import between
from test.blind.errors import BlindError
from test.blind.generator import Case, excess_after_refit, main, make_case, more_records
from test.blind.measure import COLUMNS, Noise
from test.blind.places import PLACES

pytestmark = pytest.mark.slow

CONTRACT = [
    "gas_spring",
    "preload",
    "coulomb_friction",
    "stribeck_friction",
    "quadratic_damping",
    "asymmetric_damping",
    "shear_thinning",
    "position_dependent_damping",
    "end_stop",
    "bouc_wen_hysteresis",
    "viscoelastic_branch",
    "fluid_inertia",
    "mount_compliance",
    "freeplay",
    "cavitation",
    "field_viscosity",
    "field_stiffness",
    "varying_time_constant",
    "rise_fall_asymmetry",
    "dead_time",
    "field_exponent",
    "duty_dead_band",
    "amplifier_lag",
    "self_heating",
    "effectiveness_fade",
    "force_delay",
    "force_lag",
    "velocity_lag",
    "deflection_zero",
]


@pytest.fixture(scope="module")
def case(tmp_path_factory: pytest.TempPathFactory) -> Case:
    """One written case of usual length."""
    return make_case("coulomb_friction", 4, out=tmp_path_factory.mktemp("blind") / "case")


def test_every_contract_name_can_be_hidden() -> None:
    """In this order, which seeds draw by; later ones follow."""
    assert [effect.name for effect in INSIDE][: len(CONTRACT)] == CONTRACT
    assert len(OUTSIDE) >= 6
    assert all(effect.name.startswith("outside:") for effect in OUTSIDE)
    assert sorted(effect.slot for effect in BY_NAME.values()) == list(range(N_EFFECTS))


def test_every_law_acts_in_a_place_that_there_is() -> None:
    """One that is nowhere called would be a truth that does nothing."""
    places = {place for effect in EVERY for place in effect.acts}
    assert places == {*PLACES, "shown"}


def test_nothing_of_the_product_is_imported() -> None:
    here = Path(__file__).parent
    allowed = {"numpy", "scipy", "numba", "test", "pytest"}
    standard = {
        "argparse",
        "ast",
        "functools",
        "json",
        "hashlib",
        "math",
        "pathlib",
        "shutil",
        "sys",
    }
    standard |= {
        "__future__",
        "collections",
        "dataclasses",
        "importlib",
        "inspect",
        "pkgutil",
        "typing",
    }
    seen: set[str] = set()
    for path in here.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.Import):
                seen |= {alias.name.split(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                seen.add((node.module or "").split(".")[0])
    assert seen <= allowed | standard
    assert {"numpy", "numba"} <= seen


def test_same_seed_same_files(case: Case, tmp_path: Path) -> None:
    again = make_case("coulomb_friction", 4, out=tmp_path / "again")
    for first, second in zip(case.csv, again.csv, strict=True):
        assert first.read_bytes() == second.read_bytes()
    other = make_case("coulomb_friction", 5, out=tmp_path / "other", n_records=1, seconds=5.0)
    assert other.csv[0].read_bytes() != case.csv[0].read_bytes()
    assert other.hidden[0].row[0] != case.hidden[0].row[0]


def test_files_hold_the_contract_columns(case: Case) -> None:
    assert len(case.csv) == 3
    for path in case.csv:
        assert path.read_text().splitlines()[0] == ",".join(COLUMNS)
        table = np.loadtxt(path, delimiter=",", skiprows=1)
        assert table.shape == (round(case.seconds * 200), 8)
        assert 20.0 <= case.seconds <= 30.0
        np.testing.assert_allclose(np.diff(table[:, 0]), 0.005, atol=1e-9)
        duty = table[:, COLUMNS.index("duty")]
        assert duty.min() == 0.0
        assert 0.15 < duty.max() <= 0.3


def test_truth_is_sealed_and_complete(case: Case) -> None:
    truth = json.loads((case.sealed / "truth.json").read_text())
    assert truth["effects"] == ["coulomb_friction"]
    assert truth["hidden"][0]["parameters"]["F_c"]["value"] == case.hidden[0].row[0]
    assert truth["rise_together"] == pytest.approx(case.hidden[0].rise)
    assert set(truth["sha256"]) == {path.name for path in case.csv}
    with np.load(case.sealed / "record_1.truth.npz") as sealed:
        np.testing.assert_array_equal(sealed["damper_force"], case.clean[0]["damper_force"])


@pytest.mark.parametrize("kind", ["white", "ar1"])
def test_noise_is_as_stated(kind: str, tmp_path: Path) -> None:
    noise = Noise(kind="white" if kind == "white" else "ar1")
    case = make_case(None, 8, out=tmp_path / kind, n_records=2, seconds=25.0, noise=noise)
    stated = {
        "deflection": 20e-6,
        "deflection_velocity": 1e-3,
        "damper_force": 0.15,
        "sprung_acceleration": 0.025,
        "unsprung_acceleration": 0.025,
    }
    for name, value in stated.items():
        error = np.concatenate(
            [
                noisy[name] - clean[name]
                for noisy, clean in zip(case.noisy, case.clean, strict=True)
            ]
        )
        assert np.std(error) == pytest.approx(value, rel=0.05)
        correlation = np.corrcoef(error[1:], error[:-1])[0, 1]
        coloured = kind == "ar1" and name == "damper_force"
        assert correlation == pytest.approx(0.5 if coloured else 0.0, abs=0.05)
    for name in ("t", "road", "duty"):
        np.testing.assert_array_equal(case.noisy[0][name], case.clean[0][name])


def test_target_is_hit(tmp_path: Path) -> None:
    for target in (0.3, 2.0):
        case = make_case("force_lag", 3, out=tmp_path / f"{target}", seconds=10.0, target=target)
        assert excess_after_refit(case) == pytest.approx(target, rel=0.2)
    with pytest.raises(BlindError, match="dead_time: expected a rise of 10 to 600 %"):
        make_case("dead_time", 3, out=tmp_path / "no", n_records=1, seconds=4.0, target=1e-4)


def test_pair_is_calibrated_one_by_one(tmp_path: Path) -> None:
    names = ["coulomb_friction", "dead_time"]
    case = make_case(names, 2, out=tmp_path / "pair", n_records=2, seconds=10.0)
    assert list(case.effects) == names
    assert all(0.1 <= one.rise <= 6.0 for one in case.hidden)
    single = make_case("dead_time", 2, out=tmp_path / "one", n_records=2, seconds=10.0)
    np.testing.assert_array_equal(case.hidden[1].row, single.hidden[0].row)
    assert 0.1 <= excess_after_refit(case) <= 6.0
    quiet, much = Noise(force=0.03), ["field_viscosity", "asymmetric_damping"]
    with pytest.raises(
        BlindError, match="asymmetric_damping: expected a rise of 10 to 600 % toge"
    ):
        make_case(
            much, 2, out=tmp_path / "much", n_records=1, seconds=6.0, noise=quiet, target=5.6
        )


def test_more_records_keep_the_truth(case: Case, tmp_path: Path) -> None:
    fresh = more_records(case, 77, out=tmp_path / "fresh", n_records=2, seconds=8.0)
    np.testing.assert_array_equal(fresh.table, case.table)
    np.testing.assert_array_equal(fresh.base, case.base)
    assert np.any(fresh.clean[0]["road"][:1000] != case.clean[0]["road"][:1000])
    poor = more_records(
        case, 77, out=tmp_path / "poor", n_records=2, seconds=8.0, program="one_sine"
    )
    assert np.ptp(np.concatenate([record["duty"] for record in poor.clean])) == 0.0
    np.testing.assert_array_equal(poor.clean[0]["road"], poor.clean[1]["road"])
    held = more_records(
        case, 77, out=tmp_path / "held", n_records=2, seconds=8.0, program="constant_duty"
    )
    assert np.ptp(np.concatenate([record["duty"] for record in held.clean])) == 0.0
    assert np.any(held.clean[0]["road"] != held.clean[1]["road"])


def test_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "cli"
    arguments = ["--seed", "6", "--out", str(out), "--records", "1", "--seconds", "4"]
    assert main(["--effect", "random", *arguments]) == 0
    truth = json.loads((out / "sealed" / "truth.json").read_text())
    assert truth["effects"][0] in CONTRACT
    assert capsys.readouterr().out == f"{out / 'record_1.csv'}\n"
    before = (out / "record_1.csv").read_bytes()
    assert main(["--effect", "none", *arguments]) == 2
    assert "expected a folder without a case, found record_1.csv" in capsys.readouterr().err
    assert (out / "record_1.csv").read_bytes() == before
    arguments[3] = str(tmp_path / "unknown")
    assert main(["--effect", "colomb", *arguments]) == 2
    assert "found 'colomb'" in capsys.readouterr().err
    assert not (tmp_path / "unknown").exists()


def test_random_effects_cover_the_catalogue() -> None:
    rng = np.random.default_rng(0)
    drawn = np.array([between(rng, 0.15, 4.0) for _ in range(400)])
    assert drawn.min() > 0.15
    assert drawn.max() < 4.0
    assert 0.6 < np.median(drawn) < 1.0
