"""Hosts that others wrote, at our board in software: pyfirmata2 here, npm's firmata in peer.js.

python peers.py --board COMMAND… : the command that runs the board, and says at which port.
"""

import argparse
import subprocess
import sys
import time
from pathlib import Path

import pyfirmata2

MOTOR, BRAKE, DIRECTION = 5, 6, 4
PIN_STATE_QUERY, PIN_STATE, REPORT_FIRMWARE, REPORT_VERSION = 0x6D, 0x6E, 0x79, 0xF9
WANTED = 50


def until(said, seconds=30.0):
    """Waits until something is so."""
    end = time.monotonic() + seconds
    while not said():
        if time.monotonic() > end:
            raise SystemExit("pyfirmata2: the board did not answer")
        time.sleep(0.005)


def python_host(port):
    board = pyfirmata2.Board(port, baudrate=57600)
    able = [place for place, pin in enumerate(board.digital) if pin.PWM_CAPABLE]
    assert able == [3, 5, 6, 9, 10, 11], able
    assert len(board.analog) == 6, board.analog

    states = {}
    board.add_cmd_handler(PIN_STATE, lambda pin, mode, low, high: states.update({pin: (mode, low + 128 * high)}))
    values = []
    board.samplingOn(10)
    # What a board says when opening its port resets it; one in software has begun before.
    board.sp.write(bytes([REPORT_VERSION]))
    board.send_sysex(REPORT_FIRMWARE, [])
    until(lambda: board.get_firmata_version() and board.firmware)
    assert board.get_firmata_version() == (2, 5), board.get_firmata_version()
    assert board.firmware == "zwidth simulated board", board.firmware
    board.analog[0].register_callback(values.append)
    board.analog[0].enable_reporting()
    until(lambda: len(values) >= WANTED)
    assert all(0 <= value <= 1 for value in values), values

    def state(pin):
        states.clear()
        board.send_sysex(PIN_STATE_QUERY, [pin])
        until(lambda: pin in states)
        return states[pin]

    brake = board.get_pin(f"d:{BRAKE}:p")
    brake.write(0.5)
    assert state(BRAKE) == (pyfirmata2.PWM, 128), states
    brake.write(0)
    # The motor moves the lever, which the sensor sees.
    start = values[-1]
    board.get_pin(f"d:{DIRECTION}:o").write(1)
    motor = board.get_pin(f"d:{MOTOR}:p")
    motor.write(1.0)
    until(lambda: abs(values[-1] - start) > 20 / 1023)
    motor.write(0)
    assert state(MOTOR) == (pyfirmata2.PWM, 0), states
    board.exit()
    print(f"pyfirmata2: {len(values)} analog values, pulses read back, the motor moves the lever")


def with_board(command, host):
    board = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        first = board.stdout.readline()
        assert first.startswith("a board is at "), first
        host(first.removeprefix("a board is at ").strip())
    finally:
        board.kill()
        board.wait()


def node_host(port):
    subprocess.run(["node", str(Path(__file__).with_name("peer.js")), port], check=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--board", nargs="+", required=True)
    command = parser.parse_args().board
    with_board(command, python_host)
    with_board(command, node_host)
    return 0


if __name__ == "__main__":
    sys.exit(main())
