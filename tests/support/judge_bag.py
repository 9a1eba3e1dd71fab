# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""Reads a bag with the readers that other people use and says what they saw.

usage: judge_bag.py BAG [--killed] [--undecoded SUFFIX ...]

Judges: rosbags (the directory, each message decoded from the definition text within the bag), mcap (every check sum),
mcap-ros2-support (each message decoded again, by other code). They must agree with each other on every count. Prints one
JSON object {"messages": N, "topics": {name: {"type": ..., "count": N, "hash": ...}}, "custom_data": {...}}; exits 1 and says
why when a judge refuses the bag.

--undecoded: messages of types whose names end so are counted but not decoded, because no judge knows types of services and actions.
--killed: the recording was never closed; only the linear readers can judge, and a torn end is no offence.
"""

import argparse
import json
import pathlib
import sys

from mcap.exceptions import EndOfFile, McapError
from mcap.reader import NonSeekingReader, make_reader
from mcap_ros2.decoder import DecoderFactory


class Decoders(DecoderFactory):
    """Leaves messages of some types as bytes."""

    def __init__(self, undecoded):
        super().__init__()
        self.undecoded = undecoded

    def decoder_for(self, message_encoding, schema):
        if schema is not None and schema.name.endswith(self.undecoded):
            return bytes
        return super().decoder_for(message_encoding, schema)


def mcap_counts(files, killed, undecoded):
    counts, types, hashes, last = {}, {}, {}, 0
    for path in files:
        sequence = {}
        with open(path, "rb") as stream:
            if killed:
                reader = NonSeekingReader(stream, validate_crcs=True, decoder_factories=[Decoders(undecoded)])
            else:
                reader = make_reader(stream, validate_crcs=True, decoder_factories=[Decoders(undecoded)])
                assert reader.get_header().profile == "ros2", "profile is not ros2"
            try:
                order = {} if killed else {"log_time_order": False}
                for schema, channel, message, decoded in reader.iter_decoded_messages(**order):
                    assert schema.encoding == "ros2msg", f"{schema.name}: {schema.encoding}"
                    assert channel.message_encoding == "cdr", channel.topic
                    assert sorted(channel.metadata) == ["offered_qos_profiles", "topic_type_hash"], channel.topic
                    assert message.log_time > last, f"{channel.topic}: log time {message.log_time} after {last}"
                    expected = sequence.get(channel.topic, message.sequence - 1) + 1
                    assert message.sequence == expected, f"{channel.topic}: number {message.sequence} for {expected}"
                    assert decoded is not None
                    last = message.log_time
                    sequence[channel.topic] = message.sequence
                    counts[channel.topic] = counts.get(channel.topic, 0) + 1
                    types[channel.topic] = schema.name
                    hashes[channel.topic] = channel.metadata["topic_type_hash"]
            except (EndOfFile, McapError) as error:
                if not killed:
                    raise
                print(f"{path.name}: ends with {type(error).__name__}", file=sys.stderr)
            if not killed:
                # The index must lead to the same messages as the walk.
                stream.seek(0)
                indexed = sum(1 for _ in make_reader(stream, validate_crcs=True).iter_messages())
                stream.seek(0)
                statistics = make_reader(stream).get_summary().statistics
                assert indexed == statistics.message_count, f"index: {indexed}, statistics: {statistics.message_count}"
    return counts, types, hashes


def rosbags_counts(bag, undecoded):
    from rosbags.highlevel import AnyReader

    counts, custom = {}, {}
    with AnyReader([bag]) as reader:
        inner = reader.readers[0]
        custom = dict(getattr(inner, "metadata", {}).get("custom_data") or {})
        for connection, _, raw in reader.messages():
            if not connection.msgtype.endswith(undecoded):
                reader.deserialize(raw, connection.msgtype)
            counts[connection.topic] = counts.get(connection.topic, 0) + 1
        total = sum(counts.values())
        assert reader.message_count == total, f"metadata.yaml says {reader.message_count} messages, there are {total}"
        for connection in reader.connections:
            told, seen = connection.msgcount, counts.get(connection.topic, 0)
            assert told == seen, f"{connection.topic}: metadata.yaml says {told} messages, there are {seen}"
    return counts, custom


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("bag", type=pathlib.Path)
    parser.add_argument("--killed", action="store_true")
    parser.add_argument("--undecoded", nargs="+", default=[])
    args = parser.parse_args()
    undecoded = tuple(args.undecoded)
    files = sorted(args.bag.glob("*.mcap"), key=lambda p: (len(p.name), p.name))
    assert files, f"{args.bag} has no storage file"
    counts, types, hashes = mcap_counts(files, args.killed, undecoded)
    custom = {}
    if not args.killed:
        others, custom = rosbags_counts(args.bag, undecoded)
        assert others == counts, f"rosbags counts {others}, mcap counts {counts}"
    topics = {t: {"type": types[t], "count": counts[t], "hash": hashes[t]} for t in sorted(counts)}
    print(json.dumps({"messages": sum(counts.values()), "topics": topics, "custom_data": custom}))


if __name__ == "__main__":
    try:
        main()
    except Exception as error:  # A judge's refusal, whatever its kind, is the verdict.
        print(f"{type(error).__name__}: {error}", file=sys.stderr)
        sys.exit(1)
