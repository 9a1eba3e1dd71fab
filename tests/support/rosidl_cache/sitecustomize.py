# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""Lets the generators of rosidl share what they parse. Python imports this at its start where PYTHONPATH names this folder.

Each of the generators parses every interface file with a slow general parser, which takes three quarters of its time. Here the first one
stores what a file contains in the folder ROSIDL_CACHE, and the others read it.
"""

import hashlib
import importlib.util
import os
import pickle
import sys
from pathlib import Path


def share_results(parser):
    """Replaces the function that parses the text of a file."""
    parse = parser.parse_idl_string
    folder = Path(os.environ["ROSIDL_CACHE"])

    def parse_once(text, png_file=None):
        stored = folder / hashlib.sha256(text.encode()).hexdigest()
        if stored.is_file():
            return pickle.loads(stored.read_bytes())
        content = parse(text, png_file)
        half = stored.with_suffix(f".{os.getpid()}")
        half.write_bytes(pickle.dumps(content))
        half.replace(stored)
        return content

    parser.parse_idl_string = parse_once


class ParserFinder:
    """Finds `rosidl_parser.parser` as Python would, and changes it when it is imported."""

    def find_spec(self, name, path, target=None):
        if name != "rosidl_parser.parser":
            return None
        sys.meta_path.remove(self)
        spec = importlib.util.find_spec(name)
        execute = spec.loader.exec_module

        def exec_module(module):
            execute(module)
            share_results(module)

        spec.loader.exec_module = exec_module
        return spec


if "ROSIDL_CACHE" in os.environ:
    sys.meta_path.insert(0, ParserFinder())
