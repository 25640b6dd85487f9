"""Measurements and models from files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from er_models.model import Model
from er_models.own import effects
from er_records.dataset import Dataset
from er_records.readers.names import Given

from er_models import files
from er_records import load as records


def load(*paths: str | Path, names: Given | Path | str | None = None) -> Dataset:
    """Records of files and folders: rosbag2 recordings, .csv, .parquet, .mf4, .mat, .tdms, .xlsx; checked and repaired.

    What was repaired, derived or left out stands in the notes of each record. names: what the files' own columns are,
    such as `{"duty": {"from": "Strom [A]", "full_scale": 1.6}}`, or a YAML file that says so; else the `names.yaml` of
    their folder counts.

    Raises:
        InputError: A path that is absent, of unknown kind, empty, damaged, or implausible.
        MissingChannel: A recording without any sensor topic.
    """
    return Dataset.of(records.load([Path(path) for path in paths], names))


def load_model(name: str | Path | Model, effects_from: Sequence[str | Path] = ()) -> Model:
    """A model by its shipped name, or from a file; a model is returned as it is.

    effects_from: Python files with effects of your own, which join the catalogue.

    Raises:
        InputError: No such model, or a file that holds none.
    """
    if isinstance(name, Model):
        return name
    return files.load_model(name, effects([Path(p) for p in effects_from]))
