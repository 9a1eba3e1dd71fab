# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""Says what rosbags and mcap make of bags that have a fault each.

usage: judge_faults.py BAG...

Prints one JSON object a line for each bag: {"rosbags": {...}, "mcap": {...}}, each with "messages" (how many were read and decoded) and
"refusal" (the kind of error that the reader raised, or null). mcap reads by the index, with every check sum, and decodes with mcap-ros2-support.
"""

import json
import pathlib
import sys

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader


def verdict(reading):
    messages = 0
    try:
        for _ in reading:
            messages += 1
    except Exception as error:  # A refusal, whatever its kind, is the verdict.
        return {"messages": messages, "refusal": type(error).__name__}
    return {"messages": messages, "refusal": None}


def with_rosbags(bag):
    with AnyReader([bag]) as reader:
        for connection, _, raw in reader.messages():
            yield reader.deserialize(raw, connection.msgtype)


def with_mcap(bag):
    for path in sorted(bag.glob("*.mcap")):
        with open(path, "rb") as stream:
            reader = make_reader(stream, validate_crcs=True, decoder_factories=[DecoderFactory()])
            for *_, decoded in reader.iter_decoded_messages():
                yield decoded


for argument in sys.argv[1:]:
    bag = pathlib.Path(argument)
    print(json.dumps({"rosbags": verdict(with_rosbags(bag)), "mcap": verdict(with_mcap(bag))}), flush=True)
