# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""Reads the tables of a bag with pandas and pyarrow, and holds every value against the CSV and against what rosbags reads.

usage: judge_tables.py BAG CSV_DIRECTORY PARQUET_DIRECTORY

Prints one JSON object {"rows": N, "values": N, "types": {table: {column: Arrow's name of its type}}}; exits 1 and says why where something
differs.
"""

import csv
import json
import pathlib
import struct
import sys

import numpy
import pandas
import pyarrow
import pyarrow.parquet
from rosbags.highlevel import AnyReader

csv.field_size_limit(1 << 30)


def same(value, text, kind):
    """Whether a value is what a text of the CSV says, to the bit."""
    if pyarrow.types.is_list(kind):
        texts = text.split(" ") if text else []
        return len(value or []) == len(texts) and all(same(v, t, kind.value_type) for v, t in zip(value or [], texts))
    if value is None:
        return text == ""
    if pyarrow.types.is_boolean(kind):
        return text == ("true" if value else "false")
    if pyarrow.types.is_integer(kind):
        return value == int(text)
    if pyarrow.types.is_float64(kind):
        return struct.pack("<d", value) == struct.pack("<d", float(text)) or (value != value and text == "NaN")
    if pyarrow.types.is_float32(kind):
        return struct.pack("<f", value) == numpy.float32(text).tobytes() or (value != value and text == "NaN")
    return value == text


def told(message, path, into):
    """The values of a message as rosbags has them, by their paths."""
    if isinstance(message, (list, tuple, numpy.ndarray)):
        into[path] = message
        for index, element in enumerate(message):
            told(element, f"{path}[{index}]", into)
    elif hasattr(message, "__dataclass_fields__"):
        for name in message.__dataclass_fields__:
            if name != "__msgtype__":
                told(getattr(message, name), f"{path}.{name}" if path else name, into)
    else:
        into[path] = message


def equal(value, other):
    if isinstance(value, list):
        return len(value) == len(other) and all(equal(v, o) for v, o in zip(value, other))
    return value == other or (value != value and other != other)


def judge_table(path, csv_path):
    table, frame = pyarrow.parquet.read_table(path), pandas.read_parquet(path)
    with open(csv_path, newline="", encoding="utf-8") as stream:
        header, *rows = csv.reader(stream)
    assert header[:2] == ["log_time_ns", "publish_time_ns"] and table.column_names == ["log_time", "publish_time", *header[2:]], path
    assert (len(rows), list(frame.columns)) == (table.num_rows, table.column_names), path
    for index, time in enumerate(["log_time", "publish_time"]):
        assert str(frame[time].dtype) == "datetime64[ns, UTC]", f"{path}: {time} is {frame[time].dtype}"
        assert frame[time].astype("int64").tolist() == [int(row[index]) for row in rows], f"{path}: {time}"
    values = 0
    for index, name in enumerate(table.column_names[2:], 2):
        kind = table.schema.field(name).type
        for row, value in zip(rows, table.column(name).to_pylist()):
            assert same(value, row[index], kind), f"{path}: {name} is {value}, the CSV has {row[index]}"
            values += 1
    return table, values


def main():
    bag, csv_directory, parquet_directory = map(pathlib.Path, sys.argv[1:])
    tables, lengths, values, types = {}, {}, 0, {}
    for path in sorted(parquet_directory.glob("*.parquet")):
        table, count = judge_table(path, csv_directory / f"{path.stem}.csv")
        tables[path.stem] = {name: table.column(name).to_pylist() for name in table.column_names[2:]}
        types[path.stem] = {field.name: str(field.type) for field in table.schema}
        lengths[path.stem] = table.num_rows
        values += count
    at = dict.fromkeys(tables, 0)
    with AnyReader([bag]) as reader:
        for connection, _, raw in reader.messages():
            name = connection.topic.lstrip("/").replace("/", ".")
            if name not in tables:
                continue
            message = {}
            told(reader.deserialize(raw, connection.msgtype), "", message)
            for column, cells in tables[name].items():
                value = cells[at[name]]
                # An array of types with parts is one text where it is too long for columns.
                if value is not None and not (isinstance(value, str) and not isinstance(message.get(column), str)):
                    assert equal(value, message[column]), f"{name}, row {at[name]}: {column} is {value}, rosbags has {message[column]}"
            at[name] += 1
    assert at == lengths, f"rosbags has {at} messages, the tables {lengths}"
    print(json.dumps({"rows": sum(lengths.values()), "values": values, "types": types}))


if __name__ == "__main__":
    try:
        main()
    except Exception as error:  # A judge's refusal, whatever its kind, is the verdict.
        print(f"{type(error).__name__}: {error}", file=sys.stderr)
        sys.exit(1)
