"""The same loop, plain, with pySerial: python peer.py PORT RATE TICKS prints what `rig-bench loop` prints."""

import sys
import time
import zlib

import serial

POLL, WRITE, SEEN = 0x02, 0x03, 0x82


def frame(kind, sequence, payload=b""):
    """A frame of docs/rig.md: stuffed by COBS, and a 0 behind it. None is longer than a block."""
    plain = bytes([kind]) + sequence.to_bytes(2, "little") + payload
    plain += zlib.crc32(plain).to_bytes(4, "little")
    return b"".join(bytes([len(part) + 1]) + part for part in plain.split(b"\0")) + b"\0"


def unframe(wire):
    plain, at = b"", 0
    while at < len(wire) - 1:
        plain += wire[at + 1 : at + wire[at]] + b"\0"
        at += wire[at]
    plain = plain[:-1]
    if zlib.crc32(plain[:-4]) != int.from_bytes(plain[-4:], "little"):
        raise ValueError("a damaged frame")
    return plain[0], plain[1:-4]


def is_answer(wire, sequence):
    try:
        kind, payload = unframe(wire)
    except (ValueError, IndexError):
        return False
    return kind == SEEN and payload[:2] == sequence.to_bytes(2, "little")


def main(port, rate_hz, ticks):
    line = serial.Serial(port, 1_000_000, timeout=0.05)
    line.reset_input_buffer()
    now, looks, tick = time.perf_counter, [], 1
    begin_s = now()
    while tick <= ticks:
        deadline_s = begin_s + tick / rate_hz
        time.sleep(max(0.0, deadline_s - now()))
        woke_s = now()
        line.write(frame(POLL, tick & 0xFFFF))
        if is_answer(line.read_until(b"\0"), tick & 0xFFFF):
            line.write(frame(WRITE, tick & 0xFFFF, bytes(4)))
            done_s = now()
            looks.append((woke_s - deadline_s, done_s - woke_s))
        else:  # nothing whole within the time that the line waits: the tick is left out
            line.reset_input_buffer()
            done_s = now()
        tick = max(tick + 1, int((done_s - begin_s) * rate_hz) + 1)
    for late_s, took_s in looks:
        print(f"{late_s * 1e6:.1f} {took_s * 1e6:.1f}")


if __name__ == "__main__":
    main(sys.argv[1], float(sys.argv[2]), int(sys.argv[3]))
