// An Arduino Uno that runs a sketch in an emulator (npm's avr8js), in its own time: node board.js SKETCH.hex
//
// Lines on stdin: `angle COUNTS` and `force COUNTS` set what its sensors see; `run US HEX` gives its serial port these bytes, lets it
// run for so long, and answers `HEX MOTOR BRAKE DIRECTION MARKER TRIAL`: what it said, the pulses of pins 5 and 6, and the levels
// of 4, 7 and 8.
const fs = require("fs");
const readline = require("readline");
const avr = require("avr8js");

const CYCLES_PER_US = 16;
const [DIRECTION, MOTOR, BRAKE, DATA, CLOCK, MARKER] = [4, 5, 6, 2, 3, 7];
const TRIAL = 0; // pin 8 is the first of port B
const VOLTS = 5;
const FORCE_US = 12500;

// Registers of the ATmega328P: the outputs of timer 0 and of ports B and D (data sheet, register summary).
const [TCCR0A, OCR0A, OCR0B, PORTB, PORTD] = [0x44, 0x47, 0x48, 0x25, 0x2b];
const [COM0A1, COM0B1] = [0x80, 0x20];

function program(hex) {
  const bytes = new Uint8Array(0x8000);
  for (const line of hex.split("\n").filter((line) => line.startsWith(":"))) {
    const [size, at, kind] = [line.substr(1, 2), line.substr(3, 4), line.substr(7, 2)].map((digits) => parseInt(digits, 16));
    if (kind === 0) bytes.set(Buffer.from(line.substr(9, 2 * size), "hex"), at);
  }
  return new Uint16Array(bytes.buffer);
}

const cpu = new avr.CPU(program(fs.readFileSync(process.argv[2], "ascii")));
const port = new avr.AVRIOPort(cpu, avr.portDConfig);
const usart = new avr.AVRUSART(cpu, avr.usart0Config, CYCLES_PER_US * 1e6);
const adc = new avr.AVRADC(cpu, avr.adcConfig);
for (const config of [avr.timer0Config, avr.timer1Config, avr.timer2Config]) new avr.AVRTimer(cpu, config);

let said = [];
usart.onByteTransmit = (byte) => said.push(byte);

// The HX711: its data pin is low when it has a value, whose bits come with the pulses of its clock pin.
const cell = { force: 0, bits: 0, shifted: 0, ready: false, next: 0, clock: false };
port.setPin(DATA, true);
port.addListener(() => {
  const clock = port.pinState(CLOCK) === avr.PinState.High;
  if (clock && !cell.clock && cell.ready) {
    port.setPin(DATA, cell.shifted === 24 || Boolean((cell.bits >> (23 - cell.shifted)) & 1));
    cell.shifted += 1;
    cell.ready = cell.shifted < 25;
  }
  cell.clock = clock;
});
function weigh() {
  if (cell.ready || cpu.cycles < cell.next) return;
  Object.assign(cell, { bits: cell.force & 0xffffff, shifted: 0, ready: true, next: cpu.cycles + FORCE_US * CYCLES_PER_US });
  port.setPin(DATA, false);
}

const waiting = []; // bytes that its serial port has not taken yet
function run(us, bytes) {
  waiting.push(...bytes);
  const end = cpu.cycles + us * CYCLES_PER_US;
  while (cpu.cycles < end) {
    avr.avrInstruction(cpu);
    cpu.tick();
    if (waiting.length && !usart.rxBusy && usart.writeByte(waiting[0])) waiting.shift();
    weigh();
  }
}

const level = (port, bit) => (cpu.data[port] >> bit) & 1;
const pulses = (pin, bit, register) => (cpu.data[TCCR0A] & bit ? cpu.data[register] : cpu.data[PORTD] & (1 << pin) ? 255 : 0);

readline.createInterface({ input: process.stdin }).on("line", (line) => {
  const [word, number, hex] = line.split(" ");
  if (word === "angle") adc.channelValues[0] = ((Number(number) + 0.5) / 1024) * VOLTS;
  if (word === "force") cell.force = Number(number);
  if (word !== "run") return;
  said = [];
  run(Number(number), [...Buffer.from(hex || "", "hex")]);
  const out = [pulses(MOTOR, COM0B1, OCR0B), pulses(BRAKE, COM0A1, OCR0A)];
  out.push(level(PORTD, DIRECTION), level(PORTD, MARKER), level(PORTB, TRIAL));
  process.stdout.write(`${Buffer.from(said).toString("hex")} ${out.join(" ")}\n`);
});
