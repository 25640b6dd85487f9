"""``device_emulator``: a rig that exists only as a program, behind a real wire. Needs no ROS.

Exit status 0 on Ctrl-C, 2 with one line for bad usage.
"""

from __future__ import annotations

import argparse
import heapq
import secrets
import signal
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from time import monotonic_ns
from types import FrameType
from typing import Any, TypeAlias

from er_common.parameter_table import build as checked
from er_models.constants import SAMPLE_RATE
from er_models.errors import ErError, InputError
from er_models.one_line import OneLine
from er_models.seed import seed_reader
from er_models.yaml_file import read_yaml

from er_plant_sim.build import build
from er_plant_sim.hardware import device, impair, key_file, link, seal
from er_plant_sim.hardware.calibration import load_calibration
from er_plant_sim.hardware.device import Device, DeviceState
from er_plant_sim.hardware.impair import Wire, WireState
from er_plant_sim.hardware.link import Sender
from er_plant_sim.schedule import Progress, Schedule, due, next_due
from er_plant_sim.settings import PlantParameters

WIRES = ("pty", "udp", "serial")
Piece: TypeAlias = tuple[int, int, bytes, Sender]
"""What is on its way: when it arrives [ns], its number, bytes, whose or for whom."""


def _share(text: str) -> float:
    value = float(text)
    if not 0.0 <= value <= 1.0:
        raise argparse.ArgumentTypeError(f"expected 0 to 1, found {text}")
    return value


def parser() -> argparse.ArgumentParser:
    """Options of the command."""
    p = OneLine(prog="device_emulator", description=__doc__, allow_abbrev=False)
    p.add_argument("--link", required=True, help="pty:PATH, udp:HOST:PORT or serial:PORT[@BAUD]")
    p.add_argument("--model", required=True, metavar="FILE", help="vehicle model")
    p.add_argument(
        "--damper",
        default="",
        metavar="FILE",
        help="model whose damper replaces that of the vehicle",
    )
    p.add_argument(
        "--program",
        required=True,
        metavar="FILE",
        help="program with the road that is driven until the host sends another",
    )
    p.add_argument(
        "--calibration",
        required=True,
        metavar="FILE",
        help="calibration file: how it turns its values into counts",
    )
    p.add_argument(
        "--key",
        default="",
        metavar="FILE",
        help="key that it shares with the host; none: a wire without authentication (over UDP: the user's own)",
    )
    p.add_argument(
        "--params", metavar="FILE", help="parameter file of the plant: noise, safe duty"
    )
    p.add_argument(
        "--rate", type=float, default=SAMPLE_RATE, help=f"samples per second ({SAMPLE_RATE:g})"
    )
    p.add_argument(
        "--seed",
        type=seed_reader(),
        default=0,
        help="seed of the noise and of what the wire loses (0)",
    )
    p.add_argument("--loss", type=_share, default=0.0, help="share of the packets lost, each way")
    p.add_argument(
        "--corruption", type=_share, default=0.0, help="share of the packets damaged, each way"
    )
    p.add_argument(
        "--jitter", type=float, default=0.0, metavar="S", help="mean delay, each way [s]"
    )
    p.add_argument(
        "--drift", type=float, default=0.0, help="drift of its clock: 1e-4 is 100 ppm fast"
    )
    return p


def parameters(options: argparse.Namespace) -> PlantParameters:
    """The plant's parameters that the options mean.

    Raises:
        InputError: A file or value cannot be used.
    """
    given: dict[str, Any] = {}
    if options.params:
        text = read_yaml(Path(options.params), "a parameter file")
        try:
            given |= text["/**"]["ros__parameters"]
        except (KeyError, TypeError):
            raise InputError(options.params, "/**", "ros__parameters", "none") from None
    given |= {
        "model_file": options.model, "damper_file": options.damper, "program_file": options.program,
        "seed": options.seed, "rate": options.rate, "duration": 0.0, "duty_source": "topic",
    }  # fmt: skip
    given.setdefault("safe_duty", 0.0)
    origins = dict.fromkeys(given, options.params or "command line")
    return checked(PlantParameters, given, origins)


@dataclass
class Emulator:
    """A device, its clock and its wire."""

    device: Device
    link: link.Link
    wire: Wire
    drift: float
    began: int = field(default_factory=lambda: monotonic_ns() - 1_000_000_000)
    ended: bool = False

    def run(self) -> None:
        """Tick and answer until told to stop."""
        state = device.start(self.device)
        outward, inward = WireState(), WireState(given=1 << 40)
        going: list[Piece] = []
        coming: list[Piece] = []
        schedule = Schedule(round(1e9 * self.device.rig.dt / (1.0 + self.drift)))
        progress = Progress(monotonic_ns())
        while not self.ended:
            progress, count = due(schedule, progress, monotonic_ns())
            for place in range(progress.done - count, progress.done):
                sampled = progress.start + place * schedule.period
                state, data = device.tick(self.device, state, self.time(sampled))
                outward = self._post(going, outward, data)
            wait = min([next_due(schedule, progress), *(q[0][0] for q in (going, coming) if q)])
            data = self.link.read(max(1e-9 * (wait - monotonic_ns()), 0.0))
            if data:
                inward = self._post(coming, inward, data, self.link.sender)
            while coming and coming[0][0] <= monotonic_ns():
                _, _, piece, sender = heapq.heappop(coming)
                state, answer = self._heard(state, piece, sender)
                outward = self._post(going, outward, answer, sender)
            while going and going[0][0] <= monotonic_ns():
                _, _, piece, receiver = heapq.heappop(going)
                self.link.write(piece, receiver)

    def _heard(self, state: DeviceState, data: bytes, sender: Sender) -> tuple[DeviceState, bytes]:
        """Take a piece; whoever sent a newer frame of the session gets the samples from then on."""
        before = state.callee.taken
        state, answer = device.on_bytes(
            self.device, state, data, self.time(monotonic_ns()), datagram=self.link.datagram
        )
        if state.callee.taken != before and isinstance(self.link, link.UdpLink):
            self.link.peer = sender
        return state, answer

    def _post(
        self, queue: list[Piece], state: WireState, data: bytes, who: Sender = None
    ) -> WireState:
        """Give a piece to the wire; who: sent it, or gets it where that is not the host of before."""
        if not data:
            return state
        state, out = impair.step(self.wire, state, data, monotonic_ns())
        if out is not None:
            heapq.heappush(queue, (out[0], state.given, out[1], who))
        return state

    def time(self, now: int) -> int:
        """What the device's own clock shows [ns]: from its start, at its own pace."""
        return round((now - self.began) * (1.0 + self.drift))


def emulator(options: argparse.Namespace) -> Emulator:
    """The emulator that the options mean.

    Raises:
        InputError: A file or value cannot be used, or the wire is not to be had.
    """
    address = link.Address(options.link, WIRES, "--link")
    rig = build(parameters(options))
    boot = monotonic_ns() % 2**32
    key, note = key_file.key_of(options.key, address.kind)
    if note:
        sys.stderr.write(f"device_emulator: {note}\n")
    calibration = load_calibration(options.calibration)
    made = Device(rig, calibration, boot, key, secrets.token_bytes(seal.SEED))
    wire = Wire(
        options.loss, options.corruption, options.jitter, address.kind != "udp", options.seed
    )
    # compile before the first tick: the rig's clock must not begin with seconds of silence
    device.tick(made, device.tick(made, device.start(made), 0)[0], 0)
    try:
        return Emulator(made, link.listen(address, follow=not key), wire, options.drift)
    except OSError as error:
        raise InputError(
            "--link", "", "a wire that can be had", error.strerror or str(error)
        ) from None


def main(argv: Sequence[str] | None = None) -> None:
    """Entry point of the executable."""
    options = parser().parse_args(argv)
    made: list[Emulator] = []
    told: list[int] = []

    def tell(number: int, _: FrameType | None) -> None:
        told.append(number)
        for each in made:
            each.ended = True

    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, tell)
    try:
        made.append(emulator(options))
    except ErError as error:
        sys.stderr.write(f"device_emulator: {error}\n")
        sys.exit(error.exit_status)
    try:
        print(f"device_emulator: {options.link}, {options.rate:g} Hz", flush=True)  # noqa: T201
        if not told:
            made[0].run()
    finally:
        made[0].link.close()


if __name__ == "__main__":
    main()
