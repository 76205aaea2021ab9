// What is connected where. Change it to your wiring; nothing else has to change.
#pragma once

#define BAUD 115200UL

#define HX711_DATA 2
#define HX711_CLOCK 3

// What stands before each number: with it a line of which a piece is missing is no line. In rig.toml: line = "={hx711}".
#define BEFORE "="
