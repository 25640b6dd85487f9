/* The device's side of the wire with a key (docs/hardware.md), for firmware: C99, no allocation, no other library.
 *
 *     er_wire wire;
 *     er_wire_start(&wire, er_wire_key, seed);              // seed: 16 bytes that no earlier start had
 *     n = er_wire_take(&wire, frame, size, out, &kind);     // a frame of the host: send the n bytes of out back
 *     if (kind == 3) ...                                    // COMMAND: its payload is at frame + ER_HEADER
 *     n = er_wire_send(&wire, 2, payload, size, out);       // SAMPLE; 0 while no session is open
 *
 * The frames are whole ones: a datagram holds them one after the other, and on a serial port the receiver looks for
 * the mark, takes ER_HEADER + size of payload + ER_TAG bytes, and looks again one byte later when nothing came of
 * it. SPDX-License-Identifier: Apache-2.0 */
#ifndef ER_WIRE_H
#define ER_WIRE_H

#include <stddef.h>
#include <stdint.h>

#define ER_KEY 32    /* bytes of the key that host and device share */
#define ER_SEED 16   /* bytes that nonces are made of */
#define ER_NONCE 8   /* bytes of a nonce */
#define ER_TAG 8     /* bytes behind the payload */
#define ER_HEADER 10 /* bytes before it: mark, version, kind, size, number */
#define ER_LONGEST 80

enum { ER_CALL = 6, ER_ANSWER = 7, ER_OPEN = 8 };

typedef struct {
    uint8_t key[ER_KEY], seed[ER_SEED];
    uint8_t host[16], device[16]; /* keys of the session: of what the host sends, of what the device sends */
    uint64_t sessions;            /* opened since the start; none is in force at 0 */
    uint32_t sent, heard;         /* numbers of the last frames in it */
    int began;                    /* whether the host was heard in it */
} er_wire;

/* Keyed hash of RFC 7693: out of 1 to 32 bytes, key of 0 to 32. */
void er_blake2s(uint8_t *out, size_t out_size, const uint8_t *key, size_t key_size, const uint8_t *in, size_t size);

/* Begin; seed: from a random generator, or a counter of the starts in permanent memory. */
void er_wire_start(er_wire *wire, const uint8_t key[ER_KEY], const uint8_t seed[ER_SEED]);

/* A frame of this kind into out [ER_LONGEST]; its size, 0 without a session, for a payload that is too long, or when
 * the session has no number left. */
size_t er_wire_send(er_wire *wire, uint8_t kind, const uint8_t *payload, size_t size, uint8_t *out);

/* Take one whole frame. kind: of a newer frame of the session, ER_OPEN when another one has begun (say HELLO then),
 * 0 for everything else, which changes nothing. Returns the size of an answer in out [ER_LONGEST], 0 for none. */
size_t er_wire_take(er_wire *wire, const uint8_t *frame, size_t size, uint8_t *out, uint8_t *kind);

#endif
