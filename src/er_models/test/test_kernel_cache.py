"""The generated kernel: what it says, when it is made anew, and where it lies."""

from __future__ import annotations

import ast
import dataclasses
import inspect
import os
import subprocess
import sys
from collections.abc import Callable
from math import atan, exp, pi, tanh
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from er_models.cache import sealed
from er_models.cache.folder import cache_folder
from er_models.catalogue import CATALOGUE, Catalogue
from er_models.effect import HOOKS, Effect, Param, Signature
from er_models.files import load_model
from er_models.kernel import load
from er_models.kernel.compose import fingerprint, source
from er_models.kernel.fast import njit
from er_models.kernel.inline import inlined
from er_models.kernel.order import OF_STATE
from er_models.model import Model
from er_models.prediction import predict
from er_models.simulation import simulate
from models_help import SMALL, guo, imposed

SCALE = 2.0
FEW = Catalogue(
    tuple(CATALOGUE[n] for n in ("passive", "guo_yield", "response", "coulomb_friction"))
)
"""Enough for a damper: its kernel is compiled in a third of the time."""
CAR = Path(__file__).resolve().parents[3] / "config" / "vehicles" / "inove_quarter_car.yaml"


def scaled(F_k: float, v: float) -> float:
    """A force that refers to a constant of its module."""
    level = SCALE * F_k
    return level * tanh(v / 0.01)


def branched(F_k: float, v: float) -> float:
    """A force that cannot be written into one line."""
    if v > 0.0:
        return F_k
    return -F_k * helper(v)


def helper(v: float) -> float:
    """Something a hook calls."""
    return 1.0 - exp(v / 0.01)


def own(function: object, name: str = "own_force") -> Effect:
    """A user's own effect."""
    return Effect(
        name, "force", "Own", "Own force.", (Param("F_k", "N", 0.0, 2.0, 0.0, (0.1,), "level"),),
        {"force": function}, Signature("own", "own", "own"), "a test",  # type: ignore[dict-item]
    )  # fmt: skip


def changed(name: str, among: Catalogue = CATALOGUE, **fields: object) -> Catalogue:
    """The catalogue with one effect changed."""
    return Catalogue(
        tuple(dataclasses.replace(e, **fields) if e.name == name else e for e in among.effects)  # type: ignore[arg-type]
    )


def damper() -> Model:
    """The Guo damper in the small catalogue."""
    return dataclasses.replace(guo(), catalogue=FEW)


def test_generated_source_reads_like_the_equations() -> None:
    text = source(CATALOGUE)
    offset = CATALOGUE.column("coulomb_friction", "F_c")
    sharp, slow = (f"coulomb_friction_force_{name}" for name in ("sharp", "slow"))
    assert f"{sharp} = tanh(v / p[{offset + 1}])  # coulomb_friction" in text
    assert f"f_d += p[{offset}] * ({sharp} + {slow})" in text
    assert text.count("_compiled('") == 0


def uncopied(function: Callable[..., object]) -> Callable[..., object]:
    """A hook as one that cannot be written into its place, so that the source calls it by its name."""

    def other(*values: float) -> object:
        while True:
            return function(*values)

    other.__signature__ = inspect.signature(function)  # type: ignore[attr-defined]
    return other


def idle(catalogue: Catalogue) -> list[str]:
    """Hooks of a catalogue's effects that its composed source never calls."""
    called = [
        dataclasses.replace(e, hooks={hook: uncopied(f) for hook, f in e.hooks.items()})
        for e in catalogue.effects
    ]
    text = source(Catalogue(tuple(called)))
    hooks = [f"{e.name}__{hook}" for e in called for hook in e.hooks]
    return [hook for hook in hooks if f"{hook}(" not in text]


def test_every_hook_of_the_catalogue_acts() -> None:
    assert idle(CATALOGUE) == []


@pytest.mark.parametrize("hook", HOOKS)
def test_every_hook_that_an_effect_may_have_acts(hook: str) -> None:
    """One that is accepted and called nowhere would be an equation that does nothing."""
    hooks = dict.fromkeys((hook, *(("relax", "bound") if hook in OF_STATE else ())), nothing)
    effect = dataclasses.replace(own(scaled), hooks=hooks)
    assert f"own_force__{hook}" not in idle(CATALOGUE.extended([effect]))


def nothing() -> float:
    """A hook that asks for nothing."""
    return 0.0


def test_a_changed_equation_gives_another_kernel(monkeypatch: pytest.MonkeyPatch) -> None:
    first, second = own(scaled), own(branched)
    prints = [fingerprint(CATALOGUE.extended([e])) for e in (first, second)]
    monkeypatch.setitem(globals(), "SCALE", 3.0)
    prints.append(fingerprint(CATALOGUE.extended([own(scaled)])))
    prints.append(fingerprint(CATALOGUE))
    assert len(set(prints)) == 4


def test_a_changed_helper_gives_another_kernel(monkeypatch: pytest.MonkeyPatch) -> None:
    before = fingerprint(CATALOGUE.extended([own(branched)]))
    monkeypatch.setitem(globals(), "helper", lambda v: v)
    assert fingerprint(CATALOGUE.extended([own(branched)])) != before


def elsewhere(F_k: float, v: float) -> float:
    """A force that refers to a constant and to a compiled function of another module."""
    return F_k * other.LEVEL * other.helper(v)


other = ModuleType("other")
other.__dict__.update(LEVEL=2.0, helper=njit(helper))


def sagging(v: float) -> float:
    """Another helper."""
    return v


@pytest.mark.parametrize(
    ("name", "value"), [("LEVEL", 3.0), ("LEVEL", np.ones(2)), ("helper", njit(sagging))]
)
def test_a_change_in_another_module_gives_another_kernel(
    name: str, value: object, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = fingerprint(CATALOGUE.extended([own(elsewhere)]))
    monkeypatch.setitem(other.__dict__, name, value)
    assert fingerprint(CATALOGUE.extended([own(elsewhere)])) != before


def test_every_module_that_the_source_imports_counts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    tree = ast.parse(source(FEW))
    names = {n.module for n in ast.walk(tree) if isinstance(n, ast.ImportFrom) and n.module}
    ours = sorted(name for name in names if name.startswith("er_models"))
    assert len(ours) > 2
    found = {fingerprint(FEW)}
    for name in ours:
        (tmp_path / "changed.py").write_text("CONSTANT = 2.0\n", encoding="utf-8")
        with monkeypatch.context() as patch:
            patch.setattr(sys.modules[name], "__file__", str(tmp_path / "changed.py"))
            found.add(fingerprint.__wrapped__(FEW))
    assert len(found) == len(ours) + 1


def test_a_fingerprint_needs_no_kernel() -> None:
    """In a process that has loaded nothing of the kernel: the same as here."""
    program = "from er_models.catalogue import CATALOGUE\nfrom er_models.kernel.compose import fingerprint"
    command = [sys.executable, "-c", f"{program}\nprint(fingerprint(CATALOGUE))"]
    done = subprocess.run(command, text=True, capture_output=True, check=True)
    assert done.stdout.strip() == fingerprint(CATALOGUE)


def test_words_and_bounds_do_not_matter() -> None:
    assert fingerprint(changed("coulomb_friction", title="x", source="y")) == fingerprint(
        CATALOGUE
    )


def test_inlining_copies_what_it_can_and_calls_the_rest() -> None:
    names = {"F_k": "p[7]", "v": "v"}
    lines, expression = inlined(scaled, "own_force", names) or ([], "")
    assert lines == ["own_force_level = 2.0 * p[7]"]
    assert expression == "own_force_level * tanh(v / 0.01)"
    assert inlined(branched, "own_force", names) is None
    assert inlined(lambda F_k, v: F_k, "own_force", names) is None


@pytest.mark.parametrize("function", [scaled, branched], ids=("inlined", "called"))
def test_a_users_effect_is_compiled_into_the_damper(
    function: object, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("ER_CACHE_DIR", str(tmp_path))
    effect = own(function)
    inputs = imposed(SMALL, 0.5)
    model = Model("own", {}, SMALL, catalogue=FEW.extended([effect]))
    force = predict(model.with_effect("own_force", {"F_k": 0.5}), inputs)
    expected = [function(0.5, v) for v in inputs.v]  # type: ignore[operator]
    assert force == pytest.approx(expected, abs=1e-12)
    assert len(list((tmp_path / "er_models").rglob("er_kernel_*.py"))) == 1


def test_cache_lies_where_it_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ER_CACHE_DIR", str(tmp_path / "a"))
    assert cache_folder() == tmp_path / "a" / "er_models"
    monkeypatch.delenv("ER_CACHE_DIR")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "b"))
    assert cache_folder() == tmp_path / "b" / "er_models"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path / "c"))
    assert cache_folder() == tmp_path / "c" / ".cache" / "er_models"


def test_a_cache_that_cannot_be_written_falls_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A file in the way, whoever runs the test; the fallback can be written and is one's own."""
    (tmp_path / "blocked").write_text("", encoding="utf-8")
    monkeypatch.setenv("ER_CACHE_DIR", str(tmp_path / "blocked"))
    folder = cache_folder()
    assert folder.is_dir()
    assert not folder.is_relative_to(tmp_path)
    assert folder.stat().st_uid == os.getuid()
    assert folder.stat().st_mode & 0o022 == 0


def test_half_a_file_is_never_seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The text is complete before it has its name."""
    seen: list[str] = []
    replace = os.replace

    def watch(old: str, new: str) -> None:
        seen.append(Path(old).read_text(encoding="utf-8"))
        assert not Path(new).exists()
        replace(old, new)

    monkeypatch.setattr(os, "replace", watch)
    sealed.put(tmp_path / "kernel.py", b"text")
    assert seen == ["text"]
    assert [p.name for p in tmp_path.iterdir()] == ["kernel.py"]


PROGRAM = """
import sys
sys.path.insert(0, {test!r})
from models_help import imposed, SMALL
from test_kernel_cache import damper
from er_models.prediction import predict
print(repr(float(predict(damper(), imposed(SMALL, 0.5)).sum())))
"""


@pytest.mark.slow
def test_two_processes_compile_at_once(tmp_path: Path) -> None:
    """Both in an empty cache: the same number from both, and from a third that finds it filled."""
    environment = {**os.environ, "ER_CACHE_DIR": str(tmp_path)}
    command = [sys.executable, "-c", PROGRAM.format(test=str(Path(__file__).parent))]

    def start() -> subprocess.Popen[str]:
        return subprocess.Popen(command, env=environment, text=True, stdout=subprocess.PIPE)

    both = [start(), start()]
    results = [p.communicate(timeout=120)[0] for p in both]
    results.append(start().communicate(timeout=60)[0])
    expected = repr(float(predict(damper(), imposed(SMALL, 0.5)).sum()))
    assert [r.strip() for r in results] == [expected] * 3
    assert len(list((tmp_path / "er_models").rglob("er_kernel_*.py"))) == 1
    assert not list((tmp_path / "er_models").rglob("*.tmp"))


@pytest.mark.slow
def test_kernels_of_two_catalogues_live_side_by_side() -> None:
    other = changed("coulomb_friction", FEW, hooks={"force": scaled_friction})
    inputs = imposed(SMALL, 0.5)
    first = damper().with_effect("coulomb_friction")
    second = dataclasses.replace(first, catalogue=other)
    halves = [predict(m, inputs) - predict(damper(), inputs) for m in (first, second, first)]
    assert halves[1] == pytest.approx(2.0 * halves[0], abs=1e-12)
    assert np.array_equal(halves[0], halves[2])


def scaled_friction(F_c: float, v_0: float, r: float, v: float) -> float:
    """Twice the friction force [N]."""
    sharp = tanh(v / v_0)
    return 2.0 * F_c * (sharp + r * (2.0 / pi * atan(v / v_0) - sharp))


def test_samples_that_may_not_be_written_need_no_compilation_of_their_own() -> None:
    module, inputs = load.kernel(CATALOGUE), imposed(SMALL, 2.0)
    frozen = dataclasses.replace(inputs, x=inputs.x.copy(), u=inputs.u.copy())
    for samples in (frozen.x, frozen.u):
        samples.flags.writeable = False
    assert np.array_equal(predict(guo(), inputs), predict(guo(), frozen))
    assert len(module.predict_rows.signatures) == 1
    car, road = load_model(CAR), 1e-3 * np.sin(np.arange(200) / 10.0)
    free = simulate(car, 0.005, road.copy(), np.full(200, 0.1))
    road.flags.writeable = False
    assert np.array_equal(
        simulate(car, 0.005, road, np.full(200, 0.1))["damper_force"], free["damper_force"]
    )
    assert len(module.run_vehicle.signatures) == 1
