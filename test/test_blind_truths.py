"""Every effect that the lab may name can be hidden from it, or it says here why not."""

from er_models.catalogue import CATALOGUE

from test.blind.catalogue import BY_NAME

WITHOUT = {
    "field_saturation": "judged on a measured damper (docs/results/measured.md); that of field_exponent saturates too",
    "herschel_bulkley": "judged on a measured damper (docs/results/measured.md); field_viscosity has its own truth",
    "temperature_thinning": "records of the generator have no temperature; test_measured_temperature.py hides it",
    "piston_play": "judged on a measured damper (docs/results/measured.md); freeplay has its own truth",
}
"""Effects that no truth hides, and why."""


def test_every_effect_has_a_truth_or_a_reason():
    cars = (e for e in CATALOGUE.effects if e.stage == "vehicle" and e.name != "quarter_car")
    named = {e.name for e in (*CATALOGUE.candidates(), *cars)}
    hidden = {name for name in BY_NAME if not name.startswith("outside:")}
    assert hidden <= named
    assert named - hidden == WITHOUT.keys()
    assert all(len(why) > 20 for why in WITHOUT.values())
