"""The process that learns: ``python -m er_model_lab.monitor.learner FOLDER``, started by `monitor.learning`."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Mapping
from pathlib import Path
from threading import Event, Thread
from time import monotonic
from typing import Any

import numpy as np
from er_models.errors import ErError
from er_models.files import load_model, save_model
from er_models.model import Array, Model
from er_models.orphan import step_aside, wait_for_owner
from er_records.dataset import Dataset
from er_records.in_memory import from_arrays

from er_model_lab.monitor.learning import HEARD, TASK, Task
from er_model_lab.results.result import DiagnosisResult
from er_model_lab.verbs.load import load
from er_model_lab.work import STOPPED, Leader

OFTEN = 0.2
"""Time between two words on how far it is [s]."""


def learn(task: Task, heard: Mapping[str, Array], cancel: Event, say: Any) -> dict[str, Any]:
    """Diagnose, add what is missing, save the new model.

    heard: channels by name (n,), and t; say: is told content for `Learning.told`. The result by the names of the
    action: verdict, effects, noise_floor, rmse_before, rmse_after, model, reason.
    """
    from er_model_lab.verbs.improve import improve  # the page beside a graph learns elsewhere

    try:
        model = load_model(task.model)
        result = improve(_data(task, heard), model, progress=_progress(say), cancel=cancel)
    except STOPPED:
        return {"reason": "cancelled"}
    except ErError as error:
        return {"reason": " ".join(str(error).split())}
    if cancel.is_set() or result.model is None:
        return {"reason": "cancelled" if cancel.is_set() else "there is no new model"}
    return _told(result, kept(result.model, model.name, Path(task.models)))


def _data(task: Task, heard: Mapping[str, Array]) -> Dataset:
    if task.bag:
        return load(task.bag)
    return from_arrays(name="heard", **heard)  # type: ignore[arg-type]


def _progress(say: Any) -> Any:
    last = [0.0]

    def told(stage: str, done: int, total: int, ahead: tuple[Leader, ...]) -> None:
        if monotonic() - last[0] < OFTEN and done < total:
            return
        last[0] = monotonic()
        best = ahead[0] if ahead else Leader("", 0.0, 0.0)
        share = done / total if total else 0.0
        say({"stage": stage, "done": share, "best": best.effect, "best_rmse": best.rmse})

    return told


def kept(model: Model, name: str, folder: Path) -> str:
    """The new model in a file of its own, which it does not share with any before."""
    folder.mkdir(parents=True, exist_ok=True)
    number = 1
    while (path := folder / f"{name}_learnt_{number}.yaml").exists():
        number += 1
    save_model(model, path)
    return str(path.absolute())


def _told(result: DiagnosisResult, path: str) -> dict[str, Any]:
    content = result.to_dict()
    steps = [step["rmse_held_out"] for step in content["steps"]]
    return {
        "verdict": result.verdict,
        "effects": list(result.effects),
        "noise_floor": content["noise_floor"] or 0.0,
        "rmse_before": steps[0] if steps else 0.0,
        "rmse_after": steps[-1] if steps else 0.0,
        "model": path,
        "reason": content.get("reason") or result.view.headline,
    }


def main() -> None:
    """Read the task, say how far it is, and at last the result."""
    step_aside()
    folder, cancel = Path(sys.argv[1]), Event()
    task = Task(**json.loads((folder / TASK).read_text(encoding="utf-8")))
    with np.load(folder / HEARD) as file:
        heard = {name: file[name] for name in file.files}

    def say(content: dict[str, Any]) -> None:
        try:
            sys.stdout.write(f"{json.dumps(content)}\n")
            sys.stdout.flush()
        except BrokenPipeError:  # nobody is left to be told
            os._exit(0)

    def listen() -> None:
        wait_for_owner()
        cancel.set()

    Thread(target=listen, daemon=True).start()
    say({"result": learn(task, heard, cancel, say)})


if __name__ == "__main__":
    main()
