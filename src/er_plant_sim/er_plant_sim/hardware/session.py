"""How host and device agree on a session, whoever starts again and whatever is lost or forged. Pure.

    host                                     device
    CALL(h)                    -->
                               <--           ANSWER(d, h)     d: the nonce it offers until a session opens
    OPEN(d, h)                 -->           the session (d, h) is in force; another d is offered from then on
                               <--           HELLO, SAMPLE, ... under the session's keys: open for the host, too

All three are sealed with the shared key. A recorded CALL changes nothing; a recorded ANSWER is of another h, a
recorded OPEN of another d. The host calls until it hears the device, and again when that has fallen silent.
"""

from __future__ import annotations

from typing import Final, NamedTuple

from er_plant_sim.hardware import frame, seal
from er_plant_sim.hardware.frame import Answer, Call, Open
from er_plant_sim.hardware.seal import Keys

CALLING: Final = 100_000_000
"""Time between two calls [ns]."""
FRESH: Final = 1_000_000_000
"""Time after which the host calls with another nonce [ns]."""
QUIET: Final = 250_000_000
"""Silence of the device after which the host calls again [ns]."""
RENEWED: Final = 1 << 31
"""Frames after which the host asks for another session: in one session no number comes twice."""


class Caller(NamedTuple):
    """The host's side.

    seed: of its nonces, `nonces` of them used; nonce: of the calls now, empty when no answer is waited for; since,
    called_at: when it was first and last sent [ns]; keys: of the session in force; offered: of the one that opens
    with the device's first frame; heard: number of the device's last frame in this session.
    """

    seed: bytes = b""
    nonces: int = 0
    nonce: bytes = b""
    since: int = 0
    called_at: int = 0
    keys: Keys = Keys()
    offered: Keys = Keys()
    heard: int = -1

    def listening(self, key: bytes) -> tuple[bytes, ...]:
        """The keys that a frame of the device may be sealed with, that of the handshake first."""
        return tuple(each for each in (key, self.keys.device, self.offered.device) if each)


class Callee(NamedTuple):
    """The device's side.

    seed: of its nonces; sessions: how many were opened; keys: of the one in force; heard: number of the host's last
    frame in it; taken: newer frames of the host, with what opened sessions.
    """

    seed: bytes = b""
    sessions: int = 0
    keys: Keys = Keys()
    heard: int = -1
    taken: int = 0

    def listening(self, key: bytes) -> tuple[bytes, ...]:
        """The keys that a frame of the host may be sealed with, that of the handshake first."""
        return (key, self.keys.host) if self.keys.host else (key,)

    @property
    def offer(self) -> bytes:
        """The nonce of the session that opens next."""
        return seal.nonce(self.seed, self.sessions)


def due(state: Caller, now: int, *, quiet: int, sent: int) -> bool:
    """Whether to call; quiet: time since the device was heard [ns], sent: frames sent in the session."""
    wanted = not state.keys.host or quiet > QUIET or sent >= RENEWED
    return wanted and now - state.called_at >= CALLING


def call(key: bytes, state: Caller, now: int) -> tuple[Caller, bytes]:
    """Ask for a session."""
    if not state.nonce or now - state.since >= FRESH:
        made = seal.nonce(state.seed, state.nonces)
        state = state._replace(nonce=made, nonces=state.nonces + 1, since=now)
    return state._replace(called_at=now), frame.encode(Call(state.nonce), 0, key)


def answered(key: bytes, state: Caller, answer: Answer) -> tuple[Caller, bytes]:
    """Open the session that the device offers; an answer to another call is none."""
    if not state.nonce or answer.host != state.nonce:
        return state, b""
    offered = seal.session_keys(key, answer.device, answer.host)
    return state._replace(offered=offered), frame.encode(Open(*answer), 0, key)


def ordered(state: Caller, seq: int, key: bytes) -> tuple[Caller, bool]:
    """Whether a frame of the device, sealed with this key, is a newer one; the first one offered opens the session."""
    if key == state.offered.device:
        state = state._replace(keys=state.offered, offered=Keys(), nonce=b"", heard=-1)
    if key != state.keys.device or seq <= state.heard:
        return state, False
    return state._replace(heard=seq), True


def answer(key: bytes, state: Callee, asked: Call) -> bytes:
    """What a call is answered with; it changes nothing here."""
    return frame.encode(Answer(state.offer, asked.host), 0, key)


def opened(key: bytes, state: Callee, asked: Open) -> tuple[Callee, bool]:
    """Whether a session opens: with the nonce that is offered now, and no other."""
    if asked.device != state.offer:
        return state, False
    keys = seal.session_keys(key, asked.device, asked.host)
    return Callee(state.seed, state.sessions + 1, keys, taken=state.taken + 1), True


def followed(state: Callee, seq: int, key: bytes) -> tuple[Callee, bool]:
    """Whether a frame of the host, sealed with this key, is a newer one of the session in force."""
    if key != state.keys.host or seq <= state.heard:
        return state, False
    return state._replace(heard=seq, taken=state.taken + 1), True
