"""MATLAB and TDMS: what is read with a mapping, and the one line for each bad file."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

pytest.importorskip("nptdms")
from er_models.errors import ErError, InputError
from er_records.load import load
from nptdms import ChannelObject, TdmsWriter
from scipy.io import savemat

N, DT = 600, 0.005
T = DT * np.arange(N)
X = 5e-3 * np.sin(2 * np.pi * 2.0 * T)
F = 60.0 * np.gradient(X, DT) + 3.0
NAMES = {
    "t": "Daten.Zeit",
    "deflection": "Daten.Messung(1) [mm]",
    "damper_force": {"from": "Daten.Messung(2)", "unit": "kN", "sign": -1},
}
STORED = {"Zeit": T, "Messung": np.column_stack([1e3 * X, -1e-3 * F]), "Ort": "hier", "Nr": 3.0}


def mat_5(path: Path) -> Path:
    """A structure with a matrix, as MATLAB saves it by default."""
    savemat(path, {"Daten": STORED, "Grenzen": np.array([1.0, 2.0, 3.0])})
    return path


def mat_73(path: Path) -> Path:
    """The same of version 7.3: HDF5 behind 512 bytes of MATLAB's own, matrices transposed."""
    with h5py.File(path, "w", userblock_size=512) as file:
        group = file.create_group("Daten")
        group["Zeit"] = T[None, :]
        group["Messung"] = STORED["Messung"].T
        group["Ort"] = np.frombuffer("hier".encode("utf-16-le"), dtype=np.uint16)[:, None]
        group["Ort"].attrs["MATLAB_class"] = np.bytes_("char")
        file["Grenzen"] = np.array([[1.0, 2.0, 3.0]])
        file.create_group("#refs#")["a"] = T
    return path


@pytest.mark.parametrize("write", [mat_5, mat_73])
def test_both_versions_of_matlab_files_are_read(tmp_path: Path, write) -> None:
    (record,) = load([write(tmp_path / "run.mat")], NAMES)
    np.testing.assert_allclose(record.t, T)
    np.testing.assert_allclose(record.channels["deflection"], X, atol=1e-12)
    np.testing.assert_allclose(record.channels["damper_force"], F, atol=1e-9)
    assert any("Grenzen" in note for note in record.notes)
    with pytest.raises(ErError, match=r"Daten\.Messung\(1\).*\./er lab map .*run\.mat$"):
        load([tmp_path / "run.mat"])


def test_columns_of_the_contract_need_no_mapping(tmp_path: Path) -> None:
    savemat(tmp_path / "run.mat", {"t": T, "deflection": X, "damper_force": F})
    np.testing.assert_allclose(load([tmp_path / "run.mat"])[0].channels["damper_force"], F)


def test_damaged_matlab_files_are_one_line(tmp_path: Path) -> None:
    for write in (mat_5, mat_73):
        path = write(tmp_path / "run.mat")
        path.write_bytes(path.read_bytes()[:700])
        with pytest.raises(InputError, match=r"run\.mat: expected a MATLAB file") as caught:
            load([path])
        assert "\n" not in str(caught.value)
    savemat(tmp_path / "run.mat", {"a": 1.0, "b": "text"})
    with pytest.raises(InputError, match="expected vectors"):
        load([tmp_path / "run.mat"])


def channel(name: str, y: np.ndarray, unit: str = "", group: str = "Messung", dt: float = DT):
    """A waveform of LabVIEW; without times where dt is 0."""
    own = {"unit_string": unit} | ({"wf_increment": dt, "wf_start_offset": 0.0} if dt else {})
    return ChannelObject(group, name, y, properties=own)


def write(path: Path, *channels: ChannelObject) -> Path:
    """Write channels to a file."""
    with TdmsWriter(path) as writer:
        writer.write_segment(list(channels))
    return path


def test_tdms_waveforms_have_units_and_times_of_their_own(tmp_path: Path) -> None:
    slow = np.where(T[::10] < 2.0, 0.0, 0.8)
    path = write(
        tmp_path / "run.tdms", channel("Weg", 1e3 * X, "mm"), channel("Kraft", -1e-3 * F, "kN"),
        channel("Strom", slow, "A", "langsam", 10 * DT), channel("Weg", slow, "mm", "langsam", 10 * DT),
    )  # fmt: skip
    names = {
        "deflection": "Messung/Weg", "damper_force": {"from": "Kraft", "sign": -1},
        "duty": {"from": "Strom", "full_scale": 1.6},
    }  # fmt: skip
    (record,) = load([path], names)
    np.testing.assert_allclose(record.t, T)
    np.testing.assert_allclose(record.channels["deflection"], X, atol=1e-12)
    np.testing.assert_allclose(record.channels["damper_force"], F, atol=1e-9)
    assert set(record.channels["duty"]) == {0.0, 0.5}
    assert record.t[np.flatnonzero(record.channels["duty"])[0]] == pytest.approx(2.0)
    with pytest.raises(InputError, match=r"Kraft.*\./er lab map .*run\.tdms$"):
        load([path])


def test_tdms_without_waveforms_is_a_table(tmp_path: Path) -> None:
    channels = (channel(n, y, dt=0.0) for n, y in {"t": T, "deflection": X}.items())
    (record,) = load([write(tmp_path / "run.tdms", *channels)])
    np.testing.assert_allclose(record.channels["deflection"], X)


def test_damaged_tdms_files_are_one_line(tmp_path: Path) -> None:
    (tmp_path / "run.tdms").write_text("some text that is no TDMS at all")
    with pytest.raises(InputError, match=r"run\.tdms: expected a TDMS file") as caught:
        load([tmp_path / "run.tdms"])
    assert "\n" not in str(caught.value)
