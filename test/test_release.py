"""A release is made only where every file names it."""

import importlib.util
import json
import shutil
from types import SimpleNamespace

import yaml

from test.conftest import ROOT

spec = importlib.util.spec_from_file_location("release", ROOT / "tools/release.py")
release = importlib.util.module_from_spec(spec)
spec.loader.exec_module(release)


def test_all_files_state_one_version():
    [version] = set(release.stated(ROOT).values())
    assert release.not_ready(ROOT, version) == []


def test_what_stands_in_the_way_is_named(tmp_path):
    for name in release.stated(ROOT):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    (tmp_path / "CHANGELOG.md").write_text("# Changelog\n")
    found = release.not_ready(tmp_path, "9.9.9")
    assert len(found) == len(release.stated(ROOT)) + 1
    assert any(line.startswith("CITATION.cff: version: expected 9.9.9, found ") for line in found)
    assert found[-1].startswith("CHANGELOG.md")


def test_a_version_that_nobody_states_is_refused(capsys):
    assert release.main(["9.9.9", "wheels"]) == 2
    assert "expected 9.9.9" in capsys.readouterr().err


def test_a_release_is_every_test_the_wheels_and_the_site(tmp_path, monkeypatch):
    steps = []
    monkeypatch.setattr(
        release, "run", lambda *words, cwd: steps.append(" ".join(map(str, words)))
    )
    monkeypatch.setattr(release, "not_ready", lambda *_: [])
    monkeypatch.setattr(release.subprocess, "run", lambda *_, **__: SimpleNamespace(stdout=""))
    monkeypatch.setattr(release.venv, "create", lambda *_, **__: None)
    assert release.main(["1.0.0", str(tmp_path), "--tag"]) == 1, "no site was made"
    assert not steps[-1].startswith("git tag")
    (tmp_path / "site").mkdir()
    (tmp_path / "site/index.html").touch()
    steps.clear()
    assert release.main(["1.0.0", str(tmp_path), "--tag"]) == 0
    wanted = (
        "git clone",
        "er test --all",
        "pip wheel",
        "pip install",
        "-c import",
        "docs_site.py",
        "git tag",
    )
    assert [word in step for word, step in zip(wanted, steps, strict=True)] == [True] * 7


def test_citation_and_codemeta_are_read():
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    assert cited["references"][0]["type"] == "thesis"
    assert cited["license"] == "Apache-2.0"
    meta = json.loads((ROOT / "codemeta.json").read_text(encoding="utf-8"))
    assert meta["@type"] == "SoftwareSourceCode"
    assert meta["name"] == cited["title"].split(":")[0]


def test_forms_and_hooks_are_yaml():
    forms = sorted((ROOT / ".github/ISSUE_TEMPLATE").glob("*.yml"))
    assert len(forms) > 3
    for path in (*forms, ROOT / ".pre-commit-config.yaml"):
        read = yaml.safe_load(path.read_text(encoding="utf-8"))
        fields = read.get("body", [])
        assert all({"type", "id", "attributes"} <= set(each) for each in fields), path
        assert path.name in ("config.yml", ".pre-commit-config.yaml") or fields
