/* See er_wire.h. SPDX-License-Identifier: Apache-2.0 */
#include "er_wire.h"

#include <string.h>

static const uint32_t IV[8] = {0x6A09E667u, 0xBB67AE85u, 0x3C6EF372u, 0xA54FF53Au,
                               0x510E527Fu, 0x9B05688Cu, 0x1F83D9ABu, 0x5BE0CD19u};
static const uint8_t SIGMA[10][16] = {
    {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15}, {14, 10, 4, 8, 9, 15, 13, 6, 1, 12, 0, 2, 11, 7, 5, 3},
    {11, 8, 12, 0, 5, 2, 15, 13, 10, 14, 3, 6, 7, 1, 9, 4}, {7, 9, 3, 1, 13, 12, 11, 14, 2, 6, 5, 10, 4, 0, 15, 8},
    {9, 0, 5, 7, 2, 4, 10, 15, 14, 1, 11, 12, 6, 8, 3, 13}, {2, 12, 6, 10, 0, 11, 8, 3, 4, 13, 7, 5, 15, 14, 1, 9},
    {12, 5, 1, 15, 14, 13, 4, 10, 0, 7, 6, 3, 9, 2, 8, 11}, {13, 11, 7, 14, 12, 1, 3, 9, 5, 0, 15, 4, 8, 6, 2, 10},
    {6, 15, 14, 9, 11, 3, 0, 8, 12, 2, 13, 7, 1, 4, 10, 5}, {10, 2, 8, 4, 7, 6, 1, 5, 15, 11, 9, 14, 3, 12, 13, 0}};

static uint32_t turned(uint32_t w, int bits) { return (w >> bits) | (w << (32 - bits)); }

static uint32_t word(const uint8_t *in) {
    return (uint32_t)in[0] | (uint32_t)in[1] << 8 | (uint32_t)in[2] << 16 | (uint32_t)in[3] << 24;
}

static void mix(uint32_t *v, int a, int b, int c, int d, uint32_t x, uint32_t y) {
    v[a] += v[b] + x;
    v[d] = turned(v[d] ^ v[a], 16);
    v[c] += v[d];
    v[b] = turned(v[b] ^ v[c], 12);
    v[a] += v[b] + y;
    v[d] = turned(v[d] ^ v[a], 8);
    v[c] += v[d];
    v[b] = turned(v[b] ^ v[c], 7);
}

/* One block of 64 bytes; length: bytes hashed with it, last: whether it is the last one. */
static void compress(uint32_t h[8], const uint8_t block[64], uint64_t length, int last) {
    uint32_t v[16], m[16];
    for (int i = 0; i < 16; i++) m[i] = word(block + 4 * i);
    for (int i = 0; i < 8; i++) v[i] = h[i], v[i + 8] = IV[i];
    v[12] ^= (uint32_t)length;
    v[13] ^= (uint32_t)(length >> 32);
    if (last) v[14] = ~v[14];
    for (int r = 0; r < 10; r++) {
        const uint8_t *s = SIGMA[r];
        for (int i = 0; i < 4; i++)
            mix(v, i, 4 + i, 8 + i, 12 + i, m[s[2 * i]], m[s[2 * i + 1]]);
        for (int i = 0; i < 4; i++)
            mix(v, i, 4 + (i + 1) % 4, 8 + (i + 2) % 4, 12 + (i + 3) % 4, m[s[8 + 2 * i]], m[s[9 + 2 * i]]);
    }
    for (int i = 0; i < 8; i++) h[i] ^= v[i] ^ v[i + 8];
}

void er_blake2s(uint8_t *out, size_t out_size, const uint8_t *key, size_t key_size, const uint8_t *in, size_t size) {
    uint32_t h[8];
    uint8_t block[64] = {0};
    uint64_t length = 0;
    for (int i = 0; i < 8; i++) h[i] = IV[i];
    h[0] ^= 0x01010000u ^ (uint32_t)key_size << 8 ^ (uint32_t)out_size;
    if (key_size) {
        memcpy(block, key, key_size);
        length = 64;
        compress(h, block, length, size == 0);
    }
    while (size > 0 || length == 0) {
        size_t part = size < 64 ? size : 64;
        memset(block, 0, sizeof block);
        if (part) memcpy(block, in, part);
        length += part;
        compress(h, block, length, part == size);
        if (part == size) break;
        in += part;
        size -= part;
    }
    for (size_t i = 0; i < out_size; i++) out[i] = (uint8_t)(h[i / 4] >> 8 * (i % 4));
}

static void put32(uint8_t *out, uint32_t value) {
    for (int i = 0; i < 4; i++) out[i] = (uint8_t)(value >> 8 * i);
}

/* The nonce that is offered until a session opens with it. */
static void offer(const er_wire *wire, uint8_t nonce[ER_NONCE]) {
    uint8_t count[8];
    for (int i = 0; i < 8; i++) count[i] = (uint8_t)(wire->sessions >> 8 * i);
    er_blake2s(nonce, ER_NONCE, wire->seed, ER_SEED, count, sizeof count);
}

static size_t sealed(const uint8_t *key, size_t key_size, uint8_t kind, uint32_t number, const uint8_t *payload,
                     size_t size, uint8_t *out) {
    const uint8_t head[6] = {0xA5, 0x5A, 2, kind, (uint8_t)size, (uint8_t)(size >> 8)};
    memcpy(out, head, sizeof head);
    put32(out + 6, number);
    if (size) memcpy(out + ER_HEADER, payload, size);
    er_blake2s(out + ER_HEADER + size, ER_TAG, key, key_size, out + 2, ER_HEADER - 2 + size);
    return ER_HEADER + size + ER_TAG;
}

/* Whether a tag is right; takes as long whatever differs. */
static int genuine(const uint8_t *key, size_t key_size, const uint8_t *frame, size_t size) {
    uint8_t tag[ER_TAG], differs = 0;
    er_blake2s(tag, ER_TAG, key, key_size, frame + 2, size - 2 - ER_TAG);
    for (int i = 0; i < ER_TAG; i++) differs |= (uint8_t)(tag[i] ^ frame[size - ER_TAG + (size_t)i]);
    return differs == 0;
}

void er_wire_start(er_wire *wire, const uint8_t key[ER_KEY], const uint8_t seed[ER_SEED]) {
    memset(wire, 0, sizeof *wire);
    memcpy(wire->key, key, ER_KEY);
    memcpy(wire->seed, seed, ER_SEED);
}

size_t er_wire_send(er_wire *wire, uint8_t kind, const uint8_t *payload, size_t size, uint8_t *out) {
    if (wire->sessions == 0 || wire->sent == UINT32_MAX || size > ER_LONGEST - ER_HEADER - ER_TAG) return 0;
    return sealed(wire->device, 16, kind, ++wire->sent, payload, size, out);
}

static int opened(er_wire *wire, const uint8_t *nonces) {
    static const uint8_t name[10] = {'e', 'r', ' ', 's', 'e', 's', 's', 'i', 'o', 'n'};
    uint8_t offered[ER_NONCE], in[sizeof name + 2 * ER_NONCE], keys[32];
    offer(wire, offered);
    if (memcmp(offered, nonces, ER_NONCE)) return 0; /* of a session that there was */
    memcpy(in, name, sizeof name);
    memcpy(in + sizeof name, nonces, 2 * ER_NONCE);
    er_blake2s(keys, sizeof keys, wire->key, ER_KEY, in, sizeof in);
    memcpy(wire->host, keys, 16);
    memcpy(wire->device, keys + 16, 16);
    wire->sessions++;
    wire->sent = wire->heard = 0;
    wire->began = 0;
    return 1;
}

static int newer(er_wire *wire, uint32_t number) {
    if (wire->began && number <= wire->heard) return 0;
    wire->heard = number;
    wire->began = 1;
    return 1;
}

size_t er_wire_take(er_wire *wire, const uint8_t *frame, size_t size, uint8_t *out, uint8_t *kind) {
    const uint8_t *payload = frame + ER_HEADER;
    uint8_t asked;
    *kind = 0;
    if (size < ER_HEADER + ER_TAG || frame[0] != 0xA5 || frame[1] != 0x5A || frame[2] != 2) return 0;
    if ((size_t)(frame[4] | frame[5] << 8) != size - ER_HEADER - ER_TAG) return 0;
    asked = frame[3];
    if (asked == ER_CALL && size == ER_HEADER + ER_NONCE + ER_TAG && genuine(wire->key, ER_KEY, frame, size)) {
        uint8_t nonces[2 * ER_NONCE];
        offer(wire, nonces);
        memcpy(nonces + ER_NONCE, payload, ER_NONCE);
        return sealed(wire->key, ER_KEY, ER_ANSWER, 0, nonces, sizeof nonces, out);
    }
    if (asked == ER_OPEN && size == ER_HEADER + 2 * ER_NONCE + ER_TAG && genuine(wire->key, ER_KEY, frame, size)) {
        if (opened(wire, payload)) *kind = ER_OPEN;
        return 0;
    }
    if (asked >= ER_CALL || wire->sessions == 0 || !genuine(wire->host, 16, frame, size)) return 0;
    if (newer(wire, word(frame + 6))) *kind = asked;
    return 0;
}
