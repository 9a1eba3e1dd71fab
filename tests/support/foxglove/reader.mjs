// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
// An MCAP file as Foxglove reads it: by its index, every check sum looked at, each message decoded from the definition text within.

import { parse } from "@foxglove/rosmsg";
import { MessageReader } from "@foxglove/rosmsg2-serialization";
import { McapIndexedReader } from "@mcap/core";
import { open } from "node:fs/promises";
import * as zlib from "node:zlib";

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

// The reader of a file, and its messages, each with its channel.
export async function opened(file) {
  const handle = await open(file);
  // Node has Zstandard from its version 22 on; without it such a chunk is refused as one of an unknown compression.
  const zstd = zlib.zstdDecompressSync;
  const decompressHandlers = zstd ? { zstd: (data) => new Uint8Array(zstd(data)) } : {};
  const reader = await McapIndexedReader.Initialize({ readable: new Readable(handle), decompressHandlers });
  const decoders = new Map();
  async function* messages() {
    for await (const message of reader.readMessages({ validateCrcs: true })) {
      const channel = reader.channelsById.get(message.channelId);
      if (!decoders.has(channel.id)) {
        const schema = reader.schemasById.get(channel.schemaId);
        decoders.set(channel.id, new MessageReader(parse(new TextDecoder().decode(schema.data), { ros2: true })));
      }
      decoders.get(channel.id).readMessage(message.data);
      yield { channel, message };
    }
    await handle.close();
  }
  return { reader, messages: messages() };
}
