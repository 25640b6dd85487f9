"""``er bench wire``: what authentication costs on the wire to a device, beside the plain wire in the same run.

Processor time of this process, in turns, so that another load of the machine meets both alike; medians of the turns.
"""

from __future__ import annotations

from dataclasses import replace
from statistics import median
from time import process_time
from typing import Annotated, NamedTuple

import typer
from er_plant_sim.duty_gate import Command, Gate
from er_plant_sim.hardware import bridge, frame, parser, seal
from er_plant_sim.hardware.bridge import Bridge, BridgeState, Sources
from er_plant_sim.hardware.calibration import Calibration, Channel
from er_plant_sim.hardware.frame import Answer, Call, Hello, Sample, SyncReply
from er_plant_sim.hardware.parser import ParserState

from er_studies.bench.machine import machine
from er_studies.given_out import Json, Table, give
from er_studies.programs import program_of, run

KEY = bytes(range(seal.KEY))
PERIOD = 5_000_000
BRIDGE = Bridge(
    Calibration("bench", (Channel(1e-3),) * 6), Gate(0.0, 0.3, 0.1, 0.05), PERIOD, 0.05, Sources(1, 4)
)  # fmt: skip


class Cost(NamedTuple):
    """Processor time of a frame written, of one read, and of the host's share in a tick [s]."""

    written: float
    read: float
    tick: float


class Ended(NamedTuple):
    """A host whose wire is in use: its parameters and state, and the key that the device seals with."""

    p: Bridge
    state: BridgeState
    key: bytes


def ended(key: bytes) -> Ended:
    """The host's side with a device that was heard and whose clock is known."""
    p, now, out = replace(BRIDGE, key=key), 10**9, b""
    state = bridge.start(p, now, seed=bytes(seal.SEED))
    if key:
        state, said = bridge.on_time(p, state, now)
        (call,) = parser.step(ParserState(), said.data, (key,))[1]
        assert isinstance(call.message, Call)
        offer = Answer(bytes(seal.NONCE), call.message.host)
        out = seal.session_keys(key, *offer).device
        state, _ = bridge.on_bytes(p, state, frame.encode(offer, 0, key), now)
    said_first: tuple[frame.Message, ...] = (
        Hello(1, PERIOD, 63, 1, 50_000, 5_000),
        *(SyncReply(now, now, now),) * 30,
    )
    for number, message in enumerate(said_first):
        state, _ = bridge.on_bytes(p, state, frame.encode(message, number, out), now)
    return Ended(p, bridge.begin(state), out)


def turn(host: Ended, count: int) -> Cost:
    """Frames and ticks of one turn."""
    sample = Sample(7, 10**9, (1, 2, 3, 4, 5, 6), 63, 15_000, 6, 2, 0)
    began = process_time()
    for number in range(count):
        data = frame.encode(sample, number, host.key)
    written = process_time() - began
    keys = (host.p.key, host.key) if host.key else ()
    began = process_time()
    for _ in range(count):
        parser.step(ParserState(), data, keys)
    read = process_time() - began
    return Cost(written / count, read / count, _ticks(host, count))


def _ticks(host: Ended, count: int) -> float:
    """Processor time of one tick: a sample taken, a duty that answers it told, the time asked as often as it is [s]."""
    p, state, key = host
    now = 10**9
    coming = [
        frame.encode(Sample(n, now + n * PERIOD, (n,) * 6, 63, 15_000, n - 1, 2, 0), 1000 + n, key)
        for n in range(1, count + 1)
    ]
    began = process_time()
    for data in coming:
        now += PERIOD
        state, _ = bridge.on_time(p, state, now)
        state, _ = bridge.on_bytes(p, state, data, now, datagram=True)
        wish = Command(0.0, state.seq, 0.2, 2)
        state, _ = bridge.on_command(p, state, wish, now, valid=True)
    took = process_time() - began
    assert state.seq == count
    return took / count


def main(
    frames: Annotated[int, typer.Option(help="frames a turn", min=100, max=900)] = 900,
    turns: Annotated[int, typer.Option(help="turns of either wire", min=1)] = 15,
    json_file: Json = None,
) -> None:
    """Measure and show."""
    hosts = {"plain, CRC-32": ended(b""), "sealed, BLAKE2s": ended(KEY)}
    costs: dict[str, list[Cost]] = {name: [] for name in hosts}
    for _ in range(turns):
        for name, host in hosts.items():
            costs[name].append(turn(host, frames))
    middle = {
        name: Cost(*(median(values) for values in zip(*each, strict=True)))
        for name, each in costs.items()
    }
    plain = next(iter(middle.values()))
    rows = []
    for name, cost in middle.items():
        cells = [
            f"{1e6 * own:.1f} ({own / base:.2f})" for own, base in zip(cost, plain, strict=True)
        ]
        rows.append((name, *cells, f"{1e11 * cost.tick / PERIOD:.2f} %"))
    head = ("wire", "frame written", "frame read", "host's tick", "of a period")
    told = Table(head, rows, "processor time [us] and its ratio to the plain wire")
    give([told, machine()], json_file)


app = program_of(main)

if __name__ == "__main__":
    run(app)
