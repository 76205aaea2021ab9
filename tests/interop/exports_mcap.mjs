// Counts the messages of MCAP files by npm's @mcap/core, by their indexes, with every checksum.
//
//     TOOLS=FOLDER node exports_mcap.mjs FILE…
import { createRequire } from "node:module";
import { readFileSync } from "node:fs";

const { McapIndexedReader } = createRequire(`${process.env.TOOLS}/node_modules/`)("@mcap/core");

let messages = 0;
for (const path of process.argv.slice(2)) {
  const file = readFileSync(path);
  const readable = {
    size: async () => BigInt(file.length),
    read: async (offset, size) => new Uint8Array(file.subarray(Number(offset), Number(offset + size))),
  };
  const reader = await McapIndexedReader.Initialize({ readable });
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    JSON.parse(Buffer.from(message.data).toString());
    messages += 1;
  }
}
console.log(messages);
