// Reads a bag as Foxglove does: by its index, every check sum looked at, each message decoded from the definition text within the bag.
//
//     node judge_bag.mjs BAG
//
// Prints one JSON object {"messages": N, "topics": {name: count}}; ends with 1 and says why when the bag is refused.

import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import { McapIndexedReader } from "@mcap/core";
import { open, readdir } from "node:fs/promises";
import { join } from "node:path";

class Readable {
  constructor(handle) {
    this.handle = handle;
  }
  async size() {
    return BigInt((await this.handle.stat()).size);
  }
  async read(offset, length) {
    const buffer = new Uint8Array(Number(length));
    const { bytesRead } = await this.handle.read(buffer, 0, buffer.length, Number(offset));
    if (bytesRead !== buffer.length) {
      throw new Error(`${bytesRead} of ${buffer.length} bytes from ${offset} on`);
    }
    return buffer;
  }
}

const bag = process.argv[2];
const files = (await readdir(bag)).filter((name) => name.endsWith(".mcap")).sort();
const topics = {};
let messages = 0;
for (const file of files) {
  const handle = await open(join(bag, file));
  const reader = await McapIndexedReader.Initialize({ readable: new Readable(handle) });
  const decoders = new Map();
  let last = 0n;
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    const channel = reader.channelsById.get(message.channelId);
    if (!decoders.has(channel.id)) {
      const schema = reader.schemasById.get(channel.schemaId);
      decoders.set(channel.id, new MessageReader(parse(new TextDecoder().decode(schema.data), { ros2: true })));
    }
    decoders.get(channel.id).readMessage(message.data);
    if (message.logTime <= last) {
      throw new Error(`${file}: log time ${message.logTime} after ${last}`);
    }
    last = message.logTime;
    topics[channel.topic] = (topics[channel.topic] ?? 0) + 1;
    messages += 1;
  }
  const told = Number(reader.statistics?.messageCount ?? -1);
  const read = [...Object.values(topics)].reduce((sum, count) => sum + count, 0);
  if (files.length === 1 && told !== read) {
    throw new Error(`${file}: statistics say ${told} messages, ${read} were read`);
  }
  await handle.close();
}
console.log(JSON.stringify({ messages, topics }));
