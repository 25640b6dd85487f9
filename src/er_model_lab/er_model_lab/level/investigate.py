"""One question to one data set, whatever its level and its span: what does the model lack?"""

from __future__ import annotations

from dataclasses import replace

from er_models.errors import InputError
from er_records.dataset import Dataset

from er_model_lab.diagnosis.candidates import made_ready
from er_model_lab.level.damper import DamperLevel
from er_model_lab.level.level import Level, Question
from er_model_lab.level.study import Study, checked, told
from er_model_lab.level.vehicle import VehicleLevel
from er_model_lab.problem.fit_store import Notes
from er_model_lab.problem.stretches import with_more

LEVELS: dict[str, Level] = {level.name: level for level in (DamperLevel(), VehicleLevel())}


def level_of(name: str) -> Level:
    """The level of a name.

    Raises:
        InputError: There is none of that name.
    """
    if name not in LEVELS:
        raise InputError("level", "", " or ".join(LEVELS), name)
    return LEVELS[name]


def investigate(asked: Question, noted: Notes | None = None) -> Study:
    """What the model lacks; noted: fits made before, to which new ones are added.

    What was found on stretches of long data is checked on all of them. Where the models do worse there, the worst
    stretches join the others and the search is repeated, once.
    """
    seconds = sum(float(r.t[-1] - r.t[0]) for r in asked.data.records)
    asked.work.expect(asked.level.cost * seconds, made_ready, asked.model)

    def once(data: Dataset) -> Study:
        return checked(asked.level.searched(replace(asked, data=data), noted))

    study = once(asked.data)
    more = study.checked.missed if study.checked else []
    if more and not study.diagnosis.interrupted:
        study = once(with_more(asked.data, more))
    return told(study, again=bool(more))


def added(asked: Question, effect: str | None) -> Study:
    """The model with one named effect, or none, all refitted; of long data, checked on all of them."""
    study = asked.level.added(asked, effect)
    return told(checked(study), again=False)
