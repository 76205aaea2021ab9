// What is connected where. Change it to your wiring; nothing else has to change.
#pragma once

#define BAUD 500000UL // an ATmega's clock of 16 MHz divides it without an error

// The angle sensor's analog output: 0 V to the board's supply in one turn of the shaft.
#define ANGLE_PIN A0
#define COUNTS_PER_TURN 1024 // 10 bits; on a Teensy: analogReadResolution(12) in setup(), and 4096

// The HX711 of the load cell.
#define HX711_DATA 2
#define HX711_CLOCK 3
#define FORCE_PERIOD_US 12500UL // its pin RATE is high: 80 values a second; low: 10, and 100000 here

// The drivers: pulses for motor and brake, and a pin that is high while the motor pushes towards +theta.
#define MOTOR_PWM 5
#define MOTOR_DIRECTION 4
#define BRAKE_PWM 6
#define MOTOR_MV 12000UL // voltage at full pulses
#define BRAKE_MV 24000UL

// Markers for other recorders: a pin that is high from a trial's start to its end, and one with a pulse at its start, at
// contact, at its end and at each answer.
#define TRIAL_PIN 8
#define MARKER_PIN 7
#define MARKER_US 5000UL

#define PERIOD_US 2000UL // shortest time between two readings: what an Uno needs; a Teensy answers in 1000
#define WATCHDOG_MS 50   // without a write for so long: 0 V
#define NAME "framed 1"
