"""A simulated lever with a hand at it, as a device of zwidth by a process (docs/rig.md, "A program of your own").

rig.toml:   link = "process"
            [process]
            command = ["python3", "lever.py"]
            files = ["lever.py"]

Put this file into analysis/STUDY, then `zwidth allow STUDY` and `zwidth acquire STUDY ... --device rig`.

The lever, at the finger (x = r*theta, m its mass there):

    m x'' = F_hand + K_MOTOR u_motor - B x' - F_stop - F_brake,      F_brake at most FRICTION + K_BRAKE u_brake

F_stop is the spring of a stop beyond its angle. The brake is dry friction: in a step it can stop the lever, never turn it
round (x' loses at most dt*F_brake/m and stays 0 then). The hand pulls its lever along a minimum-jerk way there and back
(Flash & Hogan, J. Neurosci. 5 (1985) 1688) with a spring and a damper: F_hand = K_HAND (x_ref - x) + B_HAND (x_ref' - x').

A device of your own keeps `main` and `Watchdog`, and puts its library in the place of `Lever`.
"""

import json
import math
import os
import select
import sys
import time

STEP_S = 1e-4
RADIUS_M = 0.08
MASS_KG = 0.06
B = 0.4  # N s/m
K_MOTOR = 0.26  # N/V
K_BRAKE = 0.7  # N/V
FRICTION = 0.15  # N
MOTOR_MAX_V, BRAKE_MAX_V = 16.0, 24.0
STOP_RAD = math.pi / 4
K_STOP = 20_000.0  # N/m
K_HAND, B_HAND = 250.0, 8.0  # N/m, N s/m
REACTION_S, WAY_S, SWING_RAD = 0.3, 0.9, math.radians(55)


def minimum_jerk(share):
    """Way and speed at a share of the time from 0 to 1."""
    s = min(max(share, 0.0), 1.0)
    return s**3 * (10 - 15 * s + 6 * s**2), 30 * s**2 * (1 - s) ** 2


class Lever:
    def __init__(self):
        self.t_s = 0.0
        self.x, self.v = -STOP_RAD * RADIUS_M, 0.0
        self.motor_v = self.brake_v = self.force_n = 0.0
        self.trial_s = None  # when the last trial began

    def hand(self):
        """Where the hand wants the lever, m and m/s."""
        way, speed = 0.0, 0.0
        if self.trial_s is not None:
            since_s = self.t_s - self.trial_s - REACTION_S
            there, there_v = minimum_jerk(since_s / WAY_S)
            back, back_v = minimum_jerk((since_s - WAY_S) / WAY_S)
            way, speed = there - back, (there_v - back_v) / WAY_S
        return (-STOP_RAD + SWING_RAD * way) * RADIUS_M, SWING_RAD * speed * RADIUS_M

    def advance(self, to_s):
        """Semi-implicit Euler; dry friction as an impulse that is never more than the speed."""
        # After a pause of the machine the lever goes on from where it was.
        self.t_s = max(self.t_s, to_s - 0.2)
        brake_n = FRICTION + K_BRAKE * self.brake_v
        while self.t_s < to_s:
            dt = min(STEP_S, to_s - self.t_s)
            x_ref, v_ref = self.hand()
            self.force_n = K_HAND * (x_ref - self.x) + B_HAND * (v_ref - self.v)
            end = STOP_RAD * RADIUS_M
            stop_n = K_STOP * (max(self.x - end, 0.0) + min(self.x + end, 0.0))
            force_n = self.force_n + K_MOTOR * self.motor_v - B * self.v - stop_n
            v = self.v + dt * force_n / MASS_KG
            self.v = math.copysign(max(abs(v) - dt * brake_n / MASS_KG, 0.0), v)
            self.x += dt * self.v
            self.t_s += dt


class Watchdog:
    """Without a command for its time both voltages go to 0."""

    def __init__(self, device):
        self.device, self.wait_s, self.heard_s, self.tripped = device, 0.05, 0.0, False

    def drive(self, now_s, motor_v, brake_v):
        self.heard_s, self.tripped = now_s, False
        self.device.motor_v = min(max(motor_v, -MOTOR_MAX_V), MOTOR_MAX_V)
        self.device.brake_v = min(max(brake_v, 0.0), BRAKE_MAX_V)

    def look(self, now_s):
        is_on = self.device.motor_v or self.device.brake_v
        if is_on and now_s - self.heard_s > self.wait_s:
            self.device.motor_v = self.device.brake_v = 0.0
            self.tripped = True


def main():
    lever = Lever()
    watchdog = Watchdog(lever)
    began = time.monotonic()
    text = b""
    while True:
        # Woken by a line, or every 10 ms, so that the watchdog looks though nobody asks.
        if select.select([0], [], [], 0.01)[0]:
            came = os.read(0, 65536)
            if not came:  # zwidth has ended: nothing may stay on
                lever.motor_v = lever.brake_v = 0.0
                return
            text += came
        watchdog.look(time.monotonic() - began)
        *lines, text = text.split(b"\n")
        for line in lines:
            now_s = time.monotonic() - began
            told = json.loads(line)
            if told["say"] == "see":
                lever.advance(now_s)
                answer(
                    n=told["n"],
                    t_s=now_s,
                    angle_rad=lever.x / RADIUS_M,
                    force_n=lever.force_n,
                    tripped=watchdog.tripped,
                )
            elif told["say"] == "drive":
                lever.advance(now_s)
                watchdog.drive(now_s, told["motor_v"], told["brake_v"])
            elif told["say"] == "mark" and told["what"] == "trial":
                lever.advance(now_s)
                lever.trial_s = now_s
            elif told["say"] == "who":
                watchdog.wait_s = told["watchdog_s"]
                answer(
                    n=told["n"],
                    protocol=1,
                    name="lever.py 1",
                    rate_hz=1000,
                    force_rate_hz=1000,
                    motor_max_v=MOTOR_MAX_V,
                    brake_max_v=BRAKE_MAX_V,
                    watchdog_s=watchdog.wait_s,
                    simulated=True,
                )


def answer(**told):
    os.write(1, json.dumps(told).encode() + b"\n")


if __name__ == "__main__":
    try:
        main()
    except Exception as fault:  # what goes wrong is told in the session, and the lever is let go
        answer(error=str(fault))
        sys.exit(1)
