"""``./er study``: the thesis made again, our estimators beside their rivals, measured data of others.

er study thesis CHAPTER [ARGS]        make a chapter of the thesis again, with its figures beside ours
er study observers [SCENARIO] [ARGS]  observers beside Kalman filters on named drives, and the thesis's tables
er study classes [ARGS]               observers with and without deflection sensor and their peers, ISO A to E
er study tune_peers [ARGS]            the peers tuned, the same number of trials for each
er study variants [ARGS]              every theorem in every form, with its gamma or why it has none
er study figures [ARGS]               frequency responses of the observers' errors, figures of chapters 3 to 5
er study fault_trials [ARGS]          the fault estimator on random drives, and beside its rivals
er study fault_statistics [ARGS]      hundreds of drives on roads of every kind, with faults and without
er study alarms [ARGS]                the monitor's test on errors drawn at random: false alarms, delays
er study monitor DATA --model M [ARGS]  the live monitor along measured runs: its alarms, how soon it finds growth
er study damaged_frames [ARGS]        frames of the hardware bridge by the million, damaged in every way
er study reach DATA --model M [ARGS]  what held-out records leave to trees and to those who know more than a model
er study import KIND SOURCE [ARGS]    a measured data set of another laboratory in the lab's columns

-h after a name shows its arguments.
"""

from __future__ import annotations

from er_studies.programs import hand_over

PARTS = {
    "thesis": "er_studies.thesis.command",
    "observers": "er_studies.observers.command",
    "classes": "er_studies.observers.classes_command",
    "tune_peers": "er_studies.observers.peers.tune",
    "variants": "er_studies.observers.variants_command",
    "figures": "er_studies.observers.frequency.command",
    "fault_trials": "er_studies.faults.command",
    "fault_statistics": "er_studies.faults.statistics_command",
    "alarms": "er_studies.alarms",
    "monitor": "er_studies.monitored",
    "damaged_frames": "er_studies.damaged_frames",
    "reach": "er_studies.reach",
    "import": "er_studies.importers.command",
}


def main() -> None:
    """Hand over to the study that is named."""
    hand_over("er study", PARTS, __doc__ or "")


if __name__ == "__main__":
    main()
