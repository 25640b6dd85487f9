"""The damper of a model as a unit for co-simulation: FMI 2.0 or 3.0, from the C code of the model.

Inputs are deflection, velocity, acceleration and duty (and the temperature where the model reads it), outputs the
force as the load cell shows it and that of the damper itself. The inputs that are set before a step are those at its
end; with the derivatives that FMI 2.0 knows, `fmi2SetRealInputDerivatives`, they are those at its beginning, and what
is reached with them counts. The parameter `inputs_at_start` carries the motion on from its derivatives instead.

The unit holds its sources, and a library for the machine that it is written on where that has a C compiler.
"""

from __future__ import annotations

import os
import platform
import re
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from io import BytesIO
from pathlib import Path
from xml.etree import ElementTree as Xml

from er_models.errors import ErError, InputError
from er_models.export.c_code import CCode, Slot
from er_models.files import write_whole
from er_models.model import Model
from er_models.version import __version__

VERSIONS = (2, 3)
"""Of FMI."""
COMPILERS = ("cc", "gcc", "clang")
LIBRARIES = {"linux": "so", "darwin": "dylib", "win32": "dll"}
PLATFORMS = {
    2: {"x86_64-linux": "linux64", "x86_64-windows": "win64", "x86_64-darwin": "darwin64"},
    3: {},
}  # fmt: skip
"""Names of platforms in FMI 2 where they differ from those of FMI 3."""
BASE = {
    "kg": {"kg": 1}, "m": {"m": 1}, "s": {"s": 1}, "K": {"K": 1}, "N": {"kg": 1, "m": 1, "s": -2},
    "W": {"kg": 1, "m": 2, "s": -3}, "duty": {}, "1": {},
}  # fmt: skip
"""What a unit is made of."""
INPUTS = (
    ("deflection", "m", "deflection of the damper, extension positive"),
    ("velocity", "m/s", "its velocity"),
    ("acceleration", "m/s2", "its acceleration"),
    ("duty", "1", "duty, 0 to 1"),
    ("temperature", "K", "temperature above the reference"),
)
OUTPUTS = (
    ("force", "N", "force as the load cell shows it, positive against extension"),
    (
        "true_force",
        "N",
        "force of the damper itself, before the lag, gain and delay of its sensor",
    ),
)
AT_START = "the inputs are those at the beginning of a step, and velocity and acceleration carry the motion on"
FIRST = 16
"""Value reference of the first parameter."""


@dataclass(frozen=True)
class Variable:
    """A number of the unit: its reference, name, unit, causality, bounds and start."""

    reference: int
    name: str
    unit: str
    causality: str
    text: str
    start: float | None = None
    low: float | None = None
    high: float | None = None

    @property
    def bounds(self) -> dict[str, str]:
        """Bounds, wide enough for the start."""
        if self.start is None or self.low is None or self.high is None:
            return {}
        return {
            "min": repr(float(min(self.low, self.start))),
            "max": repr(float(max(self.high, self.start))),
        }


@dataclass(frozen=True)
class Unit:
    """A unit of FMI 2 or 3 of a model's damper."""

    code: CCode
    version: int

    @cached_property
    def token(self) -> str:
        """What says that description and library belong together."""
        return f"{{{self.code.model.digest()}-{__version__}-{int(self.code.damper.catalogue.n_states)}}}"

    @cached_property
    def variables(self) -> tuple[Variable, ...]:
        """Inputs, outputs, parameters."""
        shown = INPUTS if self.code.reads_temperature else INPUTS[:-1]
        inputs = [Variable(1 + i, n, u, "input", t, 0.0) for i, (n, u, t) in enumerate(shown)]
        outputs = [
            Variable(1 + len(INPUTS) + i, n, u, "output", t) for i, (n, u, t) in enumerate(OUTPUTS)
        ]
        parameters = [self._parameter(i, s) for i, s in enumerate(self.code.slots)]
        return (*inputs, *outputs, *parameters)

    def _parameter(self, i: int, s: Slot) -> Variable:
        """A parameter of the model."""
        return Variable(
            FIRST + i, s.name, s.unit, "parameter", s.param.meaning, s.value, s.low, s.high
        )

    @cached_property
    def sources(self) -> Mapping[str, str]:
        """C files by name."""
        more = {"TOKEN": self.token, "COUNT": str(len(self.code.slots))}
        own = {name: self.code.filled(name, more) for name in ("unit.h", f"fmi{self.version}.c")}
        return {**self.code.files, **own}

    def description(self) -> bytes:
        """modelDescription.xml."""
        model, three = self.code.model, self.version == 3
        words = {
            "fmiVersion": f"{self.version}.0", "modelName": model.name, "description": model.source or model.name,
            "generationTool": f"er_models {__version__}", "variableNamingConvention": "structured",
            "instantiationToken" if three else "guid": self.token,
        }  # fmt: skip
        root = Xml.Element("fmiModelDescription", words)
        able = {
            "modelIdentifier": self.code.name,
            "canHandleVariableCommunicationStepSize": "true",
        }
        state = "State" if three else "state"
        able |= {f"canGetAndSetFMU{state}": "true", f"canSerializeFMU{state}": "true"}
        unit = Xml.SubElement(
            root, "CoSimulation", able | ({} if three else {"canInterpolateInputs": "true"})
        )
        if not three:
            files = Xml.SubElement(unit, "SourceFiles")
            for name in self._compiled:
                Xml.SubElement(files, "File", name=name)
        self._units(root)
        Xml.SubElement(root, "DefaultExperiment", startTime="0", stopTime="10", stepSize="0.001")
        (self._variables_3 if three else self._variables_2)(root)
        return bytes(Xml.tostring(root, "utf-8", xml_declaration=True))

    @property
    def _compiled(self) -> list[str]:
        """Sources that are compiled."""
        return [name for name in self.sources if name.endswith(".c")]

    def _units(self, root: Xml.Element) -> None:
        """Units and what they are made of."""
        defined = Xml.SubElement(root, "UnitDefinitions")
        for name in dict.fromkeys(["s", *(v.unit for v in self.variables)]):
            unit = Xml.SubElement(defined, "Unit", name=name)
            Xml.SubElement(unit, "BaseUnit", {k: str(n) for k, n in base_units(name).items()})

    def _variables_3(self, root: Xml.Element) -> None:
        """Variables and structure of FMI 3."""
        listed = Xml.SubElement(root, "ModelVariables")
        Xml.SubElement(
            listed, "Float64", name="time", valueReference="0", causality="independent", variability="continuous",
            unit="s",
        )  # fmt: skip
        for v in self.variables:
            Xml.SubElement(
                listed, "Float64", {**_named(v), "unit": v.unit, **v.bounds, **_started(v)}
            )
        switch = {
            "name": "inputs_at_start",
            "valueReference": "8",
            "causality": "parameter",
            "variability": "fixed",
        }
        Xml.SubElement(listed, "Boolean", switch | {"description": AT_START, "start": "false"})
        structure = Xml.SubElement(root, "ModelStructure")
        for kind in ("Output", "InitialUnknown"):
            for v in self.variables:
                if v.causality == "output":
                    Xml.SubElement(structure, kind, valueReference=str(v.reference))

    def _variables_2(self, root: Xml.Element) -> None:
        """Variables and structure of FMI 2."""
        listed = Xml.SubElement(root, "ModelVariables")
        for v in self.variables:
            one = Xml.SubElement(listed, "ScalarVariable", _named(v))
            Xml.SubElement(one, "Real", {"unit": v.unit, **v.bounds, **_started(v)})
        switch = {
            "name": "inputs_at_start",
            "valueReference": "8",
            "causality": "parameter",
            "variability": "fixed",
        }
        one = Xml.SubElement(listed, "ScalarVariable", switch | {"description": AT_START})
        Xml.SubElement(one, "Boolean", start="false")
        structure = Xml.SubElement(root, "ModelStructure")
        for kind in ("Outputs", "InitialUnknowns"):
            part = Xml.SubElement(structure, kind)
            for i, v in enumerate(self.variables, 1):
                if v.causality == "output":
                    Xml.SubElement(part, "Unknown", index=str(i))

    def build_description(self) -> bytes:
        """sources/buildDescription.xml of FMI 3: what is compiled and linked on each platform."""
        root = Xml.Element("fmiBuildDescription", fmiVersion="3.0")
        for name in (
            "x86_64-linux",
            "aarch64-linux",
            "x86_64-windows",
            "x86_64-darwin",
            "aarch64-darwin",
        ):
            made = Xml.SubElement(
                root, "BuildConfiguration", modelIdentifier=self.code.name, platform=name
            )
            files = Xml.SubElement(made, "SourceFileSet", language="C99")
            for source in self._compiled:
                Xml.SubElement(files, "SourceFile", name=source)
            if name.endswith("linux"):
                Xml.SubElement(made, "Library", name="m", external="true")
        return bytes(Xml.tostring(root, "utf-8", xml_declaration=True))

    def library(self) -> tuple[str, bytes] | None:
        """The library for this machine with its place in the unit; None without a C compiler.

        Raises:
            ErError: the compiler fails.
        """
        compiler = os.environ.get("CC") or next(filter(shutil.which, COMPILERS), None)
        if compiler is None or sys.platform not in LIBRARIES:
            return None
        with tempfile.TemporaryDirectory() as place:
            folder = Path(place)
            for name, text in self.sources.items():
                (folder / name).write_text(text, encoding="utf-8")
            out = f"{self.code.name}.{LIBRARIES[sys.platform]}"
            words = [
                *compiler.split(),
                "-std=c99",
                "-O2",
                "-fPIC",
                "-shared",
                "-fvisibility=hidden",
                *self._compiled,
            ]
            _compiled([*words, "-o", out, "-lm"], folder)
            name = here()
            return f"binaries/{PLATFORMS[self.version].get(name, name)}/{out}", (
                folder / out
            ).read_bytes()


def _compiled(words: list[str], folder: Path) -> None:
    """Run a compiler; what it says is one line."""
    try:
        done = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
        said = (done.stderr.strip() or f"status {done.returncode}") if done.returncode else ""
    except OSError as error:
        said = str(error)
    if said:
        line = next((s for s in said.splitlines() if "error" in s.lower()), said.splitlines()[0])
        raise ErError(f"the C compiler '{words[0]}' fails: {line.strip()}")


def _named(v: Variable) -> dict[str, str]:
    """Name, reference, causality and meaning."""
    how = {"parameter": "tunable"}.get(v.causality, "continuous")
    return {
        "name": v.name, "valueReference": str(v.reference), "causality": v.causality, "variability": how,
        "description": v.text, **({"initial": "calculated"} if v.causality == "output" else {}),
    }  # fmt: skip


def _started(v: Variable) -> dict[str, str]:
    """The start, where there is one."""
    return {} if v.start is None else {"start": repr(float(v.start))}


def base_units(unit: str) -> dict[str, int]:
    """Exponents of the base units of a unit such as ``N s/m/duty``."""
    found: dict[str, int] = {}
    top, *below = unit.split("/")
    for sign, part in ((1, top), *((-1, b) for b in below)):
        for factor in part.split():
            name, power = re.fullmatch(r"(\D+|1)(\d*)", factor).groups()  # type: ignore[union-attr]
            for base, n in BASE[name].items():
                found[base] = found.get(base, 0) + sign * n * int(power or 1)
    return {base: n for base, n in found.items() if n}


def here() -> str:
    """This platform in the words of FMI 3."""
    machine = {"amd64": "x86_64", "arm64": "aarch64"}.get(
        platform.machine().lower(), platform.machine().lower()
    )
    return f"{machine}-{ {'win32': 'windows'}.get(sys.platform, sys.platform) }"


def write_fmu(model: Model, path: Path, version: int = 3) -> bool:
    """Write a model's damper as a unit of FMI 2 or 3; whether it holds a library for this machine.

    Raises:
        InputError: another version, or a place that cannot be written.
        ErError: a hook has no form in C, or the C compiler fails.
    """
    if version not in VERSIONS:
        raise InputError("fmi", "", "2 or 3", version)
    if path.suffix.lower() != ".fmu":
        raise InputError(path, "suffix", ".fmu", f"'{path.suffix}'")
    unit = Unit(CCode(model), version)
    content = {"modelDescription.xml": unit.description()}
    content |= {f"sources/{name}": text.encode() for name, text in unit.sources.items()}
    content |= {"sources/buildDescription.xml": unit.build_description()} if version == 3 else {}
    library = unit.library()
    content |= dict([library]) if library else {}
    packed = BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in content.items():
            place = zipfile.ZipInfo(name)
            place.compress_type = zipfile.ZIP_DEFLATED
            place.external_attr = (0o755 if name.startswith("binaries") else 0o644) << 16
            archive.writestr(place, data)
    write_whole(path, packed.getvalue())
    return library is not None
