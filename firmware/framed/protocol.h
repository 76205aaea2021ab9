// Frames and numbers of docs/rig.md, protocol version 1. No pins, no clock: bytes in, bytes out.
#pragma once
#include <stdint.h>
#include <string.h>

#define PROTOCOL 1
#define MOST_PAYLOAD 64
#define AROUND 7 // kind, sequence, CRC-32
#define MOST_FRAME (MOST_PAYLOAD + AROUND)

enum Kind : uint8_t { HELLO = 0x01, POLL = 0x02, WRITE = 0x03, MARK = 0x04, DESCRIPTION = 0x81, SEEN = 0x82 };
enum Mark : uint8_t { HOMING = 3, MOMENT = 4 };
enum Moment : uint16_t { START = 1, CONTACT = 2, END = 3, ANSWER = 4 };

// CRC-32 of IEEE 802.3, half a byte at a time: bit by bit an ATmega would need as long as for sending.
inline uint32_t crc32(const uint8_t *bytes, uint8_t length) {
    static const uint32_t HALF[16] = {
        0x00000000, 0x1DB71064, 0x3B6E20C8, 0x26D930AC, 0x76DC4190, 0x6B6B51F4, 0x4DB26158, 0x5005713C,
        0xEDB88320, 0xF00F9344, 0xD6D6A3E8, 0xCB61B38C, 0x9B64C2B0, 0x86D3D2D4, 0xA00AE278, 0xBDBDF21C,
    };
    uint32_t crc = 0xFFFFFFFF;
    for (uint8_t i = 0; i < length; i++) {
        crc = HALF[(crc ^ bytes[i]) & 15] ^ (crc >> 4);
        crc = HALF[(crc ^ (bytes[i] >> 4)) & 15] ^ (crc >> 4);
    }
    return ~crc;
}

// Numbers are little-endian.
inline uint8_t *put(uint8_t *at, uint32_t number, uint8_t bytes) {
    while (bytes--) {
        *at++ = number;
        number >>= 8;
    }
    return at;
}

inline uint32_t get(const uint8_t *at, uint8_t bytes) {
    uint32_t number = 0;
    while (bytes--) number = number << 8 | at[bytes];
    return number;
}

// A frame as it is between two zeros and after: kind, sequence, payload, CRC-32.
struct Frame {
    uint8_t bytes[MOST_FRAME];
    uint8_t length; // without the CRC-32

    uint8_t kind() const { return bytes[0]; }
    uint16_t sequence() const { return get(bytes + 1, 2); }
    const uint8_t *payload() const { return bytes + 3; }
    uint8_t size() const { return length - 3; }

    void begin(uint8_t kind, uint16_t sequence) {
        bytes[0] = kind;
        put(bytes + 1, sequence, 2);
        length = 3;
    }
    void add(uint32_t number, uint8_t size) {
        put(bytes + length, number, size);
        length += size;
    }

    // Writes it stuffed, and the 0 behind it: no block is longer than a frame, so each has its own zero.
    uint8_t encode(uint8_t *out) {
        put(bytes + length, crc32(bytes, length), 4);
        uint8_t code = 0, at = 1;
        for (uint8_t i = 0; i < length + 4; i++) {
            if (bytes[i]) {
                out[at++] = bytes[i];
            } else {
                out[code] = at - code;
                code = at++;
            }
        }
        out[code] = at - code;
        out[at++] = 0;
        return at;
    }
};

// Takes bytes as they come. What is no frame is dropped: after the next 0 it is right again.
struct Frames {
    uint8_t bytes[MOST_FRAME + 1];
    uint8_t length = 0;
    bool overlong = false;

    bool push(uint8_t byte, Frame &frame) {
        if (byte) {
            if (length < sizeof bytes) bytes[length++] = byte;
            else overlong = true;
            return false;
        }
        const bool whole = !overlong && decode(frame);
        length = 0;
        overlong = false;
        return whole;
    }

  private:
    bool decode(Frame &frame) {
        uint8_t to = 0;
        for (uint8_t from = 0; from < length;) {
            const uint8_t code = bytes[from++];
            if (from + code - 1 > length) return false;
            for (uint8_t i = 1; i < code; i++) {
                if (to == MOST_FRAME) return false;
                frame.bytes[to++] = bytes[from++];
            }
            if (from < length) {
                if (to == MOST_FRAME) return false;
                frame.bytes[to++] = 0;
            }
        }
        if (to < AROUND) return false;
        frame.length = to - 4;
        return get(frame.bytes + frame.length, 4) == crc32(frame.bytes, frame.length);
    }
};
