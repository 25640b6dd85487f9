"""A cluster that is simulated: Dask's own scheduler in a time of its own, with workers that only take their time.

What Dask's scheduler does is what it would do: every message goes through its state, and the processor time that it
takes is counted as its time. Workers are a queue and the times that recordings took here; the client is the time that
it takes here for a batch and for a recording. Stealing of work is off; it moves nothing here, where tasks wait at the
scheduler. Nothing is sent: a message arrives after `LATENCY`.
"""

from __future__ import annotations

import heapq
import logging
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from itertools import count
from typing import Any

import numpy as np
from er_common.extras import extra
from er_model_lab.fleets.engine import AHEAD, batch_size
from er_models.model import Array

LATENCY = 0.005
"""From one process to another [s]: Dask sends what gathers in so long."""


@dataclass(frozen=True)
class Costs:
    """What is measured beforehand [s].

    batch, recording: time of the client for each; gather: time of the scheduler to pass a result on; times (n,): of
    recordings at a worker.
    """

    batch: float
    recording: float
    gather: float
    times: Array


@dataclass(frozen=True)
class Outcome:
    """How a fleet went.

    workers: how many there were; seconds: until the client has the last result; busy, scheduler, client: share of that
    time in which workers, scheduler and client did something; most: tasks at the scheduler at once; batches: that were
    handed out.
    """

    workers: int
    seconds: float
    busy: float
    scheduler: float
    client: float
    most: int
    batches: int


class _Wire:
    """Where the scheduler believes that a worker or the client is: what it sends goes into a box."""

    def __init__(self, name: str, box: list[tuple[str, Any]]) -> None:
        """The wire to `name`."""
        self._name, self._box = name, box

    def send(self, *messages: Any) -> None:
        """Put the messages into the box."""
        self._box += [(self._name, message) for message in messages]

    async def write(self, message: Any) -> None:
        """Drop the answer to whoever registers."""


class _World:
    """All that is under way; times are simulated ones [s]."""

    def __init__(
        self, scheduler: Any, workers: int, recordings: int, costs: Costs, seed: int
    ) -> None:
        """Nothing is under way."""
        self.scheduler, self.workers, self.left, self.costs = scheduler, workers, recordings, costs
        self.box: list[tuple[str, Any]] = []
        self.most = self.batches = 0
        self.busy = {"scheduler": 0.0, "client": 0.0, "workers": 0.0}
        self.end = 0.0
        self._rng = np.random.default_rng(seed)
        self._events: list[tuple[float, int, Callable[..., Any], tuple[Any, ...]]] = []
        self._order = count()
        self._free = {"scheduler": 0.0, "client": 0.0}
        self._each = 0.0
        self._size: dict[str, int] = {}
        self._waiting: dict[str, deque[Any]] = {}

    async def run(self) -> None:
        """Hand out what may wait, then let one thing follow the other until nothing is left."""
        for _ in range(AHEAD * self.workers):
            self._at(0.0, self._hand_out)
        while self._events:
            now, _, what, arguments = heapq.heappop(self._events)
            await what(now, *arguments)

    def _at(self, moment: float, what: Callable[..., Any], *arguments: Any) -> None:
        """Do something at a moment."""
        heapq.heappush(self._events, (moment, next(self._order), what, arguments))

    def _serve(self, who: str, now: float, seconds: float) -> float:
        """Somebody who does one thing after the other does this; when it is done."""
        self._free[who] = max(self._free[who], now) + seconds
        self.busy[who] += seconds
        return self._free[who]

    async def _hand_out(self, now: float) -> None:
        """The client submits a batch, if recordings are left."""
        size = min(batch_size(self._each, self.workers), self.left)
        if size:
            key = f"work-{self.batches}"
            self.left -= size
            self.batches += 1
            self._size[key] = size
            sent = self._serve("client", now, self.costs.batch)
            self._at(sent + LATENCY, self._submitted, key, _graph(key, size))

    async def _submitted(self, now: float, key: str, graph: Any) -> None:
        """The scheduler takes a batch."""
        begun = time.process_time()
        await self.scheduler.update_graph(
            client="client", expr_ser=graph, keys={key}, span_metadata={"collections": []},
            internal_priority={key: 0}, submitting_task=None,
        )  # fmt: skip
        self.most = max(self.most, len(self.scheduler.tasks))
        self._emptied(self._serve("scheduler", now, time.process_time() - begun))

    def _emptied(self, now: float) -> None:
        """What the scheduler has put into the box is on its way; a result goes through the scheduler."""
        for name, message in self.box:
            if message["op"] == "compute-task":
                self._at(now + LATENCY, self._queued, name, message["key"], message["run_id"])
            elif message["op"] == "key-in-memory":
                passed = self._serve("scheduler", now, self.costs.gather)
                self._at(passed + LATENCY, self._answered, message["key"])
        self.box.clear()

    async def _queued(self, now: float, worker: str, key: str, number: int) -> None:
        """A worker has a batch, and begins with it where it has nothing else to do."""
        waiting = self._waiting.setdefault(worker, deque())
        waiting.append((key, number))
        if len(waiting) == 1:
            self._begun(now, worker)

    def _begun(self, now: float, worker: str) -> None:
        """A worker begins with the first batch that waits."""
        size = self._size[self._waiting[worker][0][0]]
        end = now + float(self._rng.choice(self.costs.times, size).sum())
        self.busy["workers"] += end - now
        self._at(end, self._worked, worker, end - now)

    async def _worked(self, now: float, worker: str, seconds: float) -> None:
        """A worker is done with a batch, says so, and takes the next."""
        waiting = self._waiting[worker]
        key, number = waiting.popleft()
        if waiting:
            self._begun(now, worker)
        self._at(now + LATENCY, self._finished, worker, key, number, seconds)

    async def _finished(
        self, now: float, worker: str, key: str, number: int, seconds: float
    ) -> None:
        """The scheduler hears that a batch is done."""
        begun, moment = time.process_time(), time.time()
        self.scheduler.handle_task_finished(
            key=key, worker=worker, stimulus_id=f"done-{key}", status="OK", nbytes=1000 * self._size[key], type=b"",
            typename="tuple", metadata={}, thread=1, run_id=number,
            startstops=({"action": "compute", "start": moment - seconds, "stop": moment},),
        )  # fmt: skip
        self._emptied(self._serve("scheduler", now, time.process_time() - begun))

    async def _answered(self, now: float, key: str) -> None:
        """The client has the result of a batch, enters it, and hands out another."""
        size = self._size.pop(key)
        mean = float(np.mean(self.costs.times))
        self._each = mean if self._each == 0.0 else 0.7 * self._each + 0.3 * mean
        self.end = done = self._serve("client", now, size * self.costs.recording)
        self._at(done + LATENCY, self._released, key)
        self._at(done, self._hand_out)

    async def _released(self, now: float, key: str) -> None:
        """The scheduler forgets a batch whose result the client has."""
        begun = time.process_time()
        self.scheduler.client_releases_keys(
            keys=[key], client="client", stimulus_id=f"release-{key}"
        )
        self._emptied(self._serve("scheduler", now, time.process_time() - begun))


def _graph(key: str, size: int) -> Any:
    """What Dask's client sends for a batch of so many recordings."""
    from dask._expr import LLGExpr
    from dask._task_spec import Task
    from distributed.protocol.serialize import Serialized, serialize

    task = Task(key, len, [f"recordings/{k:07d}.parquet" for k in range(size)])
    graph: Any = LLGExpr({key: task})  # type: ignore[no-untyped-call]
    return Serialized(*serialize(graph, serializers=["pickle"]))  # type: ignore[no-untyped-call]


async def simulated(workers: int, recordings: int, costs: Costs, seed: int = 0) -> Outcome:
    """A fleet of recordings on so many workers."""
    with extra("er_model_lab[fleet]", "a simulated cluster"):
        import dask
        from distributed import Scheduler
    for name in ("distributed.scheduler", "distributed.core"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    with dask.config.set({"distributed.scheduler.work-stealing": False}):
        scheduler = await Scheduler(
            protocol="inproc", dashboard=False, dashboard_address="127.0.0.1:0", port=0
        )
        try:
            world = _World(scheduler, workers, recordings, costs, seed)
            await _registered(scheduler, workers, world.box)
            await world.run()
        finally:
            scheduler.stream_comms.clear()
            scheduler.client_comms.clear()
            await scheduler.close()
    busy = {who: seconds / world.end for who, seconds in world.busy.items()}
    return Outcome(
        workers,
        world.end,
        busy["workers"] / workers,
        busy["scheduler"],
        busy["client"],
        world.most,
        world.batches,
    )


async def _registered(scheduler: Any, workers: int, box: list[tuple[str, Any]]) -> None:
    """Workers of one thread that the scheduler believes in, and a client."""
    from distributed.scheduler import ClientState

    async def nobody(*_: Any) -> None:
        """No worker sends anything by itself."""

    scheduler.handle_worker = nobody
    metrics = {
        "bandwidth": {"total": 1e8, "workers": {}, "types": {}}, "memory": 0,
        "spilled_bytes": {"memory": 0, "disk": 0}, "digests_total_since_heartbeat": {},
    }  # fmt: skip
    for k in range(workers):
        address = f"tcp://10.0.{k // 250}.{k % 250}:4000"
        wire = _Wire(address, box)
        await scheduler.add_worker(
            wire, address=address, status="running", server_id=f"w{k}", nthreads=1, name=f"w{k}",
            resolve_address=False, now=time.time(), resources={}, memory_limit=1 << 32, metrics=metrics,
            services={}, local_directory="", versions={}, nanny="", extra={}, stimulus_id="register",
        )  # fmt: skip
        scheduler.stream_comms[address] = wire
    scheduler.clients["client"] = ClientState("client")
    scheduler.client_comms["client"] = _Wire("client", box)
    box.clear()
