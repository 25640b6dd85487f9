"""What a unit of FMI holds, and what stops it from being written; nothing here runs one."""

from __future__ import annotations

import zipfile
from pathlib import Path

import pytest
from er_models.errors import ErError, InputError
from er_models.export import fmu
from er_models.export.fmu import base_units, write_fmu
from models_help import guo


def test_units_are_made_of_base_units() -> None:
    assert base_units("N s/m/duty") == {"kg": 1, "s": -1}
    assert base_units("N s2/m2") == {"kg": 1, "m": -1}
    assert base_units("1/W") == {"kg": -1, "m": -2, "s": 3}
    assert base_units("m/s2") == {"m": 1, "s": -2}
    assert base_units("1") == {}


def test_without_a_compiler_it_holds_its_sources(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setattr(fmu, "COMPILERS", ("no_such_compiler",))
    assert not write_fmu(guo(), tmp_path / "a.fmu")
    names = set(zipfile.ZipFile(tmp_path / "a.fmu").namelist())
    assert names == {
        "modelDescription.xml", "sources/buildDescription.xml", "sources/fmi3.c", "sources/inove_guo.c",
        "sources/inove_guo.h", "sources/unit.h",
    }  # fmt: skip


def test_what_goes_wrong_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match="fmi: expected 2 or 3, found 1"):
        write_fmu(guo(), tmp_path / "a.fmu", 1)
    with pytest.raises(InputError, match=r"suffix: expected \.fmu, found '\.zip'"):
        write_fmu(guo(), tmp_path / "a.zip")
    monkeypatch.setenv("CC", "no_such_compiler")
    with pytest.raises(ErError, match="the C compiler 'no_such_compiler' fails: ") as told:
        write_fmu(guo(), tmp_path / "a.fmu")
    assert "\n" not in str(told.value)
    monkeypatch.setenv("CC", "false")
    with pytest.raises(ErError, match="the C compiler 'false' fails: status 1"):
        write_fmu(guo(), tmp_path / "a.fmu")
    assert not (tmp_path / "a.fmu").exists()
