# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""What real ROS 2 (rclpy, Fast CDR) makes of messages as bytes. One JSON object a line:

    {"type", "seed"}   -> {"plain", "cdr"}   a message made up from the seed (seed 0: as it is when new), as values and as bytes
    {"type", "cdr"}    -> {"plain"}          what the bytes say
"""

import json
import random
import struct
import sys

from plain import interface, to_plain
from rclpy.serialization import deserialize_message, serialize_message
from rosidl_parser.definition import AbstractNestedType, AbstractString, Array, BasicType, BoundedSequence, NamespacedType

INTEGERS = {f"{sign}int{bits}": (0 if sign else -(1 << bits - 1), (1 << bits - (0 if sign else 1)) - 1)
            for sign in ("", "u") for bits in (8, 16, 32, 64)}
TEXTS = ["", "c_axis", "µm und Grad °", "\"quoted\"\nline two", "凸轮", "a" * 300]


def made_up(slot, dice):
    if isinstance(slot, Array):
        return [made_up(slot.value_type, dice) for _ in range(slot.size)]
    if isinstance(slot, AbstractNestedType):
        longest = slot.maximum_size if isinstance(slot, BoundedSequence) else 5
        return [made_up(slot.value_type, dice) for _ in range(min(longest, dice.choice([0, 1, 2, 5])))]
    if isinstance(slot, NamespacedType):
        return filled(interface("/".join(slot.namespaced_name())), dice)
    if isinstance(slot, AbstractString):
        text = dice.choice(TEXTS)
        return text[: slot.maximum_size] if slot.has_maximum_size() else text
    assert isinstance(slot, BasicType), slot
    kind = slot.typename
    if kind == "boolean":
        return dice.random() < 0.5
    if kind == "octet":
        return bytes([dice.randrange(256)])
    if kind in INTEGERS:
        low, high = INTEGERS[kind]
        return dice.choice([low, high, 0, dice.randint(low, high)])
    value = dice.choice([0.0, -0.0, 1.0, dice.uniform(-1e3, 1e3), dice.uniform(-1, 1) * 10.0 ** dice.randint(-30, 30)])
    assert kind in ("float", "double"), kind
    return struct.unpack("f", struct.pack("f", value))[0] if kind == "float" else value


def filled(cls, dice):
    message = cls()
    for field, slot in zip(cls.get_fields_and_field_types(), cls.SLOT_TYPES):
        setattr(message, field, made_up(slot, dice))
    return message


def main():
    for line in sys.stdin:
        asked = json.loads(line)
        cls = interface(asked["type"])
        if "cdr" in asked:
            answer = {"plain": to_plain(deserialize_message(bytes.fromhex(asked["cdr"]), cls))}
        else:
            message = filled(cls, random.Random(asked["seed"])) if asked["seed"] else cls()
            answer = {"plain": to_plain(message), "cdr": serialize_message(message).hex()}
        print(json.dumps(answer, allow_nan=False), flush=True)


main()
