// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
// Says what Foxglove's reader makes of bags that have a fault each: by the index, every check sum looked at, each message decoded.
//
//     node judge_faults.mjs BAG...
//
// Prints one JSON object a line for each bag: {"messages": N, "refusal": what it said, or null}.

import { readdir } from "node:fs/promises";
import { join } from "node:path";
import { opened } from "./reader.mjs";

for (const bag of process.argv.slice(2)) {
  let messages = 0;
  let refusal = null;
  try {
    const files = (await readdir(bag)).filter((name) => name.endsWith(".mcap")).sort();
    for (const file of files) {
      const { messages: all } = await opened(join(bag, file));
      for await (const _ of all) {
        messages += 1;
      }
    }
  } catch (error) {
    refusal = String(error.message ?? error);
  }
  console.log(JSON.stringify({ messages, refusal }));
}
