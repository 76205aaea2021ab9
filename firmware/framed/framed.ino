// A board that speaks the framed protocol (docs/rig.md): angle by an analog input, force by an HX711, motor and brake by
// pulses. Without a write for 50 ms it goes to 0 V by itself: what no host can do through a cable that was pulled.
#include "protocol.h"
#include "settings.h"

// Bits of the status.
static const uint16_t FORCE_SATURATED = 2, WATCHDOG = 4;

static Frames frames;
static Frame frame;
static int16_t motor, brake; // what is out, shares of 32767
static unsigned long written_us;
static bool tripped;
static int32_t force;
static unsigned long weighed_us, told_us;
static unsigned long marked_us;
static bool marking;

// A share as a step of analogWrite, rounded towards 0.
static uint8_t step(int16_t share) { return (uint32_t)abs((int32_t)share) * 255 / 32767; }

// The share that is really out.
static int16_t out(int16_t share) {
    const int16_t size = (uint32_t)step(share) * 32767 / 255;
    return share < 0 ? -size : size;
}

static void drive(int16_t new_motor, int16_t new_brake) {
    if (new_brake < 0) new_brake = 0;
    // The other way never gets what was meant for the one.
    if ((new_motor < 0) != (motor < 0)) analogWrite(MOTOR_PWM, 0);
    digitalWrite(MOTOR_DIRECTION, new_motor >= 0);
    analogWrite(MOTOR_PWM, step(new_motor));
    analogWrite(BRAKE_PWM, step(new_brake));
    motor = out(new_motor);
    brake = out(new_brake);
}

static void send() {
    uint8_t wire[MOST_FRAME + 2];
    Serial.write(wire, frame.encode(wire));
}

static void describe(uint16_t sequence) {
    frame.begin(DESCRIPTION, sequence);
    frame.add(PROTOCOL, 1);
    frame.add(PERIOD_US, 4);
    frame.add(FORCE_PERIOD_US, 4);
    frame.add(COUNTS_PER_TURN, 2);
    frame.add(MOTOR_MV, 4);
    frame.add(BRAKE_MV, 4);
    frame.add(WATCHDOG_MS, 2);
    frame.add(0, 1); // nothing of it is simulated
    memcpy(frame.bytes + frame.length, NAME, sizeof NAME - 1);
    frame.length += sizeof NAME - 1;
    send();
}

// Takes a value of the HX711 once it has one: 24 bits, and a 25th pulse for channel A at gain 128 (data sheet). A pulse that
// lasts for 60 us would switch it off, so no interrupt may come within one.
static void weigh() {
    if (digitalRead(HX711_DATA)) return;
    uint32_t bits = 0;
    for (uint8_t i = 0; i < 25; i++) {
        noInterrupts();
        digitalWrite(HX711_CLOCK, HIGH);
        digitalWrite(HX711_CLOCK, LOW);
        interrupts();
        if (i < 24) bits = bits << 1 | digitalRead(HX711_DATA);
    }
    force = bits & 0x800000 ? (int32_t)(bits | 0xFF000000) : (int32_t)bits;
    weighed_us = micros();
}

static void tell(uint16_t sequence) {
    const uint16_t counts = analogRead(ANGLE_PIN);
    const unsigned long now_us = micros();
    const bool saturated = force == 0x7FFFFF || force == -0x800000L;
    frame.begin(SEEN, sequence);
    frame.add(now_us, 4);
    frame.add(counts, 2);
    frame.add(0, 2); // the angle was read just now
    frame.add(force, 4);
    frame.add(now_us - weighed_us, 4);
    frame.add((saturated ? FORCE_SATURATED : 0) | (tripped ? WATCHDOG : 0), 2);
    frame.add(motor, 2);
    frame.add(brake, 2);
    send();
    told_us = now_us;
    weigh(); // while the answer is on the line: half a millisecond before it would make it late
}

// A moment of a trial, on the marker pins. What a pulled cable cut off is over at the next homing.
static void mark(uint8_t code, uint16_t number) {
    if (code == HOMING || (code == MOMENT && number == END)) digitalWrite(TRIAL_PIN, LOW);
    if (code != MOMENT) return;
    if (number == START) digitalWrite(TRIAL_PIN, HIGH);
    digitalWrite(MARKER_PIN, HIGH);
    marked_us = micros();
    marking = true;
}

static void hear(uint8_t byte) {
    if (!frames.push(byte, frame)) return;
    const uint16_t sequence = frame.sequence();
    const uint8_t *payload = frame.payload();
    if (frame.kind() == HELLO && frame.size() == 1) describe(sequence);
    if (frame.kind() == POLL && frame.size() == 0) tell(sequence);
    if (frame.kind() == MARK && frame.size() == 3) mark(payload[0], get(payload + 1, 2));
    if (frame.kind() == WRITE && frame.size() == 4) {
        written_us = micros();
        tripped = false;
        drive(get(payload, 2), get(payload + 2, 2));
    }
}

static void watch() {
    if ((motor || brake) && micros() - written_us > WATCHDOG_MS * 1000UL) {
        drive(0, 0);
        tripped = true;
    }
    if (marking && micros() - marked_us > MARKER_US) {
        digitalWrite(MARKER_PIN, LOW);
        marking = false;
    }
}

void setup() {
    pinMode(MOTOR_DIRECTION, OUTPUT);
    pinMode(MOTOR_PWM, OUTPUT);
    pinMode(BRAKE_PWM, OUTPUT);
    drive(0, 0);
    pinMode(TRIAL_PIN, OUTPUT);
    pinMode(MARKER_PIN, OUTPUT);
    pinMode(HX711_CLOCK, OUTPUT);
    pinMode(HX711_DATA, INPUT);
    Serial.begin(BAUD);
    describe(0); // it has just begun
}

void loop() {
    while (Serial.available()) hear(Serial.read());
    watch();
    if (micros() - told_us > FORCE_PERIOD_US) weigh(); // nobody asks
}
