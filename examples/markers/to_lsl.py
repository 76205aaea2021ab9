#!/usr/bin/env python3
"""Markers of `zwidth acquire --markers tcp:127.0.0.1:9000` as a stream of the LabStreamingLayer.

    pip install pylsl
    python examples/markers/to_lsl.py --port 9000

Start it before the session, on the same machine, and record its stream with LabRecorder: `zwidth beside`
then finds the trials in the recording. Each line that arrives is pushed at once as one string sample, with
the time of its arrival by LSL's clock. What went by between a sample of the trial and that time is not
known here: the line holds the sample's own times (`t_s`, `t_device_s`), and so does the session's log, which
on Linux has that very clock too.
"""

import argparse
import json
import socket

import pylsl


def lines(server):
    """The lines of one program after another, whole."""
    while True:
        connection, _ = server.accept()
        with connection, connection.makefile("r", encoding="ascii") as stream:
            yield from stream


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--host", default="127.0.0.1", help="address to listen at")
    parser.add_argument("--port", type=int, default=9000)
    parser.add_argument("--name", default="zwidth", help="name of the stream")
    asked = parser.parse_args()
    # Irregular: a marker comes when it comes.
    info = pylsl.StreamInfo(asked.name, "Markers", 1, pylsl.IRREGULAR_RATE, "string", asked.name)
    outlet = pylsl.StreamOutlet(info)
    with socket.create_server((asked.host, asked.port)) as server:
        print(f"listening at {asked.host}:{server.getsockname()[1]}", flush=True)
        for line in lines(server):
            at = pylsl.local_clock()
            try:
                json.loads(line)
            except ValueError:
                print(f"no marker: {line.strip()}", flush=True)
                continue
            outlet.push_sample([line.strip()], at)


if __name__ == "__main__":
    main()
