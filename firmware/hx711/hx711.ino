// Prints each value of a load cell's HX711, one in a line, for the table [hx711] of rig.toml (docs/rig.md). It drives nothing,
// so it needs no watchdog: a host that gets no value for 50 ms, or three periods, goes to 0 V.
#include "settings.h"

// Takes the value that the chip has: 24 bits, and a 25th pulse for channel A at gain 128 (data sheet). A pulse that lasts for
// 60 us would switch it off, so no interrupt may come within one.
static int32_t take() {
    uint32_t bits = 0;
    for (uint8_t i = 0; i < 25; i++) {
        noInterrupts();
        digitalWrite(HX711_CLOCK, HIGH);
        digitalWrite(HX711_CLOCK, LOW);
        interrupts();
        if (i < 24) bits = bits << 1 | digitalRead(HX711_DATA);
    }
    return bits & 0x800000 ? (int32_t)(bits | 0xFF000000) : (int32_t)bits;
}

void setup() {
    pinMode(HX711_CLOCK, OUTPUT);
    pinMode(HX711_DATA, INPUT);
    Serial.begin(BAUD);
}

void loop() {
    if (digitalRead(HX711_DATA)) return; // it has no value yet
    const int32_t counts = take();
    Serial.print(F(BEFORE));
    Serial.println(counts);
}
