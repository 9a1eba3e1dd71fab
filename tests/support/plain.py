# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""ROS messages as plain values (dict, list, numbers, text) and back, for the line protocol between the tests and their peers."""

import importlib
import math

from rosidl_parser.definition import AbstractNestedType, BasicType, NamespacedType
from rosidl_pycommon import convert_camel_case_to_lower_case_underscore


def interface(name):
    """The Python class of `pkg/kind/Type`; parts of services and actions as `pkg/srv/Type_Request`, `pkg/action/Type_Goal`, ..."""
    package, kind, type_name = name.split("/")
    file = convert_camel_case_to_lower_case_underscore(type_name.split("_")[0])
    return getattr(importlib.import_module(f"{package}.{kind}._{file}"), type_name)


def to_plain(value):
    if hasattr(value, "get_fields_and_field_types"):
        return {field: to_plain(getattr(value, field)) for field in value.get_fields_and_field_types()}
    if isinstance(value, (bool, str, int)):
        return value
    if isinstance(value, bytes):  # a ROS `byte`
        return value[0]
    if isinstance(value, float) or hasattr(value, "dtype") and value.ndim == 0:
        value = value.item() if hasattr(value, "dtype") else value
        # JSON knows no NaN and no infinity: as text, the way YAML writes them.
        return value if not isinstance(value, float) or math.isfinite(value) else str(value)
    return [to_plain(item) for item in value]


def from_plain(cls, data):
    message = cls()
    types = dict(zip(cls.get_fields_and_field_types(), cls.SLOT_TYPES))
    for field, value in data.items():
        if field not in types:
            raise ValueError(f"{cls.__name__} has no field {field}")
        setattr(message, field, value_from_plain(types[field], value))
    return message


def value_from_plain(slot, value):
    if isinstance(slot, AbstractNestedType):
        return [value_from_plain(slot.value_type, item) for item in value]
    if isinstance(slot, NamespacedType):
        return from_plain(interface("/".join(slot.namespaced_name())), value)
    if isinstance(slot, BasicType):
        if slot.typename == "octet":
            return bytes([value])
        if slot.typename in ("float", "double"):
            return float(value)
    return value
