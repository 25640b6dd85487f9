"""What columns are called in English and German, and what a name and a unit say of a column."""

from __future__ import annotations

import re

from er_records.readers.names import TIME
from er_records.readers.units import quantities
from er_records.record import unit_of

WORDS: dict[str, str] = {
    TIME: "t time zeit timestamp zeitstempel uhrzeit messzeit sekunden seconds clock stamp",
    "actuator_force": "actuator aktor aktuator stellkraft stellmotor",
    "sprung_displacement": "body sprung chassis upper top aufbau karosserie gefedert oben zs",
    "unsprung_displacement": "wheel unsprung axle lower bottom rad achse ungefedert unten knuckle zus radweg",
    "deflection": "deflection displacement disp dist distance stroke travel position pos extension elongation "
    "lvdt weg hub kolbenweg federweg einfederung einfederweg ausfederung auslenkung verschiebung relativweg x s",
    "deflection_velocity": "velocity vel speed geschwindigkeit geschw kolbengeschwindigkeit v vrel",
    "duty": "duty pwm current voltage command strom spannung tastgrad tastverhaeltnis ansteuerung "
    "aussteuerung bestromung stellgroesse stellsignal feld field coil spule spulenstrom volt amp ampere i u",
    "damper_force": "force load loadcell kraft daempferkraft daempfkraft kraftmessdose kmd f fd last",
    "sprung_acceleration": "body sprung chassis upper top aufbau karosserie gefedert oben as",
    "unsprung_acceleration": "wheel unsprung axle lower bottom rad achse ungefedert unten knuckle radbeschleunigung "
    "aus",
    "road": "road base table platform excitation strasse fahrbahn anregung fusspunkt fusspunktweg tisch zr",
    "temperature": "temperature temp temperatur oeltemperatur",
    "pressure": "pressure druck press p",
}  # fmt: skip
"""Channel to the words that name it; a longer word (`Kolbenweg`) counts by its end or beginning. Those of a car come
before those of its damper, which share words with them."""
ACCELERATION = ("acceleration", "accel", "acc", "beschleunigung", "beschl", "a", "as", "aus")
DISPLACEMENT = (
    "displacement",
    "disp",
    "position",
    "pos",
    "height",
    "weg",
    "hoehe",
    "z",
    "zs",
    "zus",
)
"""Words of what sits on body or wheel: a place tells which, and without a word of the kind it is none."""
KINDS = {"acceleration": ACCELERATION, "displacement": DISPLACEMENT}
WISHES = ("soll", "sollwert", "set", "setpoint", "target", "demand", "ref", "reference")
"""Words of what was asked for: the measured one is meant."""
COMPRESSION = (
    "compression", "compressed", "jounce", "bump", "einfeder", "druckstufe", "stauch", "zusammen",
)  # fmt: skip
"""Words of a motion that is counted positive in compression."""
PRIMARY = {
    "m": "deflection", "m/s": "deflection_velocity", "1": "duty", "N": "damper_force", "s": TIME, "K": "temperature",
    "Pa": "pressure",
}  # fmt: skip
"""What a column probably is of which only the unit is known."""
NAMED, UNIT_TOO, UNIT_ALONE = 0.6, 0.3, 0.45
"""How sure a name makes, what a unit adds to it, and how sure a unit alone makes."""
_UMLAUTS = str.maketrans({"ä": "ae", "ö": "oe", "ü": "ue", "ß": "ss"})


def tokens(name: str) -> list[str]:
    """Words of a name, in small letters: `rDämpferKraft_VL` -> daempfer, kraft, vl, and what runs together."""
    apart = re.sub(r"(?<=[a-zäöüß])(?=[A-ZÄÖÜ])", " ", name)
    words = re.findall(r"[a-zäöüß]+", apart.lower())
    return [w.translate(_UMLAUTS) for w in [*words, "".join(words)]]


def fits(channel: str, name: str, unit: str) -> float:
    """How well a column's name and unit fit a channel, 0 to 0.9."""
    si = "s" if channel == TIME else unit_of(channel) or "1"
    known = quantities(unit) if unit else []
    if known and si not in known:
        return 0.0
    called = _called(channel, tokens(name))
    if known:
        alone = UNIT_ALONE if PRIMARY.get(si) == channel else 0.0
        return NAMED * called + UNIT_TOO if called else alone
    return NAMED * called * (0.5 if unit else 1.0)  # a unit that nobody knows is a doubt


def _called(channel: str, words: list[str]) -> float:
    """How clearly words name a channel, 0 to 1."""
    known = WORDS[channel].split()
    kinds = next((own for kind, own in KINDS.items() if channel.endswith(f"sprung_{kind}")), ())
    best = max((_same(word, each, of) for each in known for of in [words] for word in words), default=0.0)  # fmt: skip
    if kinds:
        kind = max((_same(w, each, words) for each in kinds for w in words), default=0.0)
        best = min(best, kind) if best else 0.4 * kind * (kinds is ACCELERATION)
    return best - 0.3 * (best > 0.3 and channel != "duty" and any(w in WISHES for w in words))


def _same(word: str, known: str, words: list[str]) -> float:
    """How clearly a word of a name is a known one; single letters count where they are the whole name."""
    if word == known:
        return 1.0 if len(known) > 2 or len(words) <= 2 else 0.5
    joined = len(known) >= 3 and (
        word.endswith(known) or (len(known) > 3 and word.startswith(known))
    )
    short = len(word) > 3 and known.startswith(word)
    return 0.85 if joined else 0.7 if short else 0.0


def counts_compression(name: str) -> bool:
    """Whether a name says that it is positive in compression."""
    return any(word.startswith(each) for word in tokens(name) for each in COMPRESSION)
