// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
// Reads a bag as Foxglove does: by its index, every check sum looked at, each message decoded from the definition text within the bag.
//
//     node judge_bag.mjs BAG
//
// Prints one JSON object {"messages": N, "topics": {name: count}}; ends with 1 and says why when the bag is refused.

import { readdir } from "node:fs/promises";
import { join } from "node:path";
import { opened } from "./reader.mjs";

const bag = process.argv[2];
const files = (await readdir(bag)).filter((name) => name.endsWith(".mcap")).sort();
const topics = {};
let messages = 0;
for (const file of files) {
  let last = 0n;
  const { reader, messages: all } = await opened(join(bag, file));
  for await (const { channel, message } of all) {
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
}
console.log(JSON.stringify({ messages, topics }));
