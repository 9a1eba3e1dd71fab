# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""Judges YAML files by a JSON Schema.

usage: judge_schema.py SCHEMA FILE...

Prints one JSON object {file: [errors]}; an empty list means that the file is valid.
"""

import json
import pathlib
import sys

import jsonschema
import yaml

schema = json.loads(pathlib.Path(sys.argv[1]).read_text())
jsonschema.Draft202012Validator.check_schema(schema)
validator = jsonschema.Draft202012Validator(schema)
result = {}
for name in sys.argv[2:]:
    errors = validator.iter_errors(yaml.safe_load(pathlib.Path(name).read_text()))
    result[name] = [f"{'.'.join(str(part) for part in error.absolute_path)}: {error.message}" for error in errors]
print(json.dumps(result))
