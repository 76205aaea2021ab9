// A host that others wrote (npm's firmata) at our board in software: what its pins can do, pulses, analog values, I2C.
// node peer.js PORT
const assert = require("assert");
const Board = require("firmata");

const AS5600 = 0x36;
const RAW_ANGLE = 0x0c;
const STATUS = 0x0b;
const [MOTOR, BRAKE, DIRECTION] = [5, 6, 4];
const fail = (what) => {
  console.error(what);
  process.exit(1);
};
setTimeout(() => fail("firmata.js: the board did not answer in 60 s"), 60000).unref();
process.on("uncaughtException", (error) => fail(error.stack));

const values = (begin, count) =>
  new Promise((resolve) => {
    const found = [];
    begin((value) => found.length < count && found.push(value) === count && resolve(found));
  });
const state = (board, pin) => new Promise((resolve) => board.queryPinState(pin, () => resolve(board.pins[pin].state)));
const counts = ([high, low]) => high * 256 + low;

const board = new Board(process.argv[2], { samplingInterval: 10 }, async (error) => {
  if (error) fail(String(error));
  const { PWM, OUTPUT, ANALOG, I2C } = board.MODES;
  assert.deepStrictEqual(board.version, { major: 2, minor: 5 });
  assert.strictEqual(board.firmware.name, "zwidth simulated board");
  assert.strictEqual(board.pins.length, 20);
  assert.deepStrictEqual(board.analogPins, [14, 15, 16, 17, 18, 19]);
  const able = (mode) => board.pins.map((pin, i) => [pin, i]).filter(([pin]) => pin.supportedModes.includes(mode)).map(([, i]) => i);
  assert.deepStrictEqual(able(PWM), [3, 5, 6, 9, 10, 11]);
  assert.deepStrictEqual(able(ANALOG), board.analogPins);
  assert.deepStrictEqual(able(I2C), [18, 19]);

  board.pinMode(BRAKE, PWM);
  board.analogWrite(BRAKE, 201);
  assert.strictEqual(await state(board, BRAKE), 201);
  board.analogWrite(BRAKE, 0);

  const before = await values((take) => board.analogRead(0, take), 50);
  assert(before.every((value) => value >= 0 && value < 1024), before.join());

  board.i2cConfig();
  const once = await new Promise((resolve) => board.i2cReadOnce(AS5600, RAW_ANGLE, 2, resolve));
  // Ten bits of the twelve.
  const away = Math.abs(counts(once) - 4 * before.at(-1));
  assert(Math.min(away, 4096 - away) <= 8, `${counts(once)} by I2C, ${before.at(-1)} by the analog input`);
  const magnet = await new Promise((resolve) => board.i2cReadOnce(AS5600, STATUS, 1, resolve));
  assert.strictEqual(magnet[0] & 0x20, 0x20);
  const again = await values((take) => board.i2cRead(AS5600, RAW_ANGLE, 2, (bytes) => take(counts(bytes))), 50);
  assert(again.every((value) => value >= 0 && value < 4096), again.join());
  board.i2cStop(AS5600);

  // The motor moves the lever, which the sensor sees.
  board.pinMode(DIRECTION, OUTPUT);
  board.digitalWrite(DIRECTION, 1);
  board.pinMode(MOTOR, PWM);
  board.analogWrite(MOTOR, 255);
  const start = before.at(-1);
  await new Promise((resolve) => board.on("analog-read-0", (value) => Math.abs(value - start) > 20 && resolve()));
  board.analogWrite(MOTOR, 0);
  assert.strictEqual(await state(board, MOTOR), 0);
  console.log(`firmata.js: ${before.length} analog values, ${again.length} of the I2C bus, pulses read back, the motor moves the lever`);
  process.exit(0);
});
