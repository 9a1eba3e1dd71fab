# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""Builds and installs the package `camwright` as colcon does: CMake with ament_cmake.

    install_package.py NODES BINARIES BUILD PREFIX

BINARIES are those that Cargo has built for the tests; colcon has CMake call Cargo. Run by the Python of the peers' environment.
"""

import os
import subprocess
import sys
from pathlib import Path


def main():
    nodes, binaries, build, prefix = sys.argv[1:]
    venv = Path(sys.executable).parent.parent
    environment = dict(os.environ, CMAKE_PREFIX_PATH=os.environ["AMENT_PREFIX_PATH"])
    environment["PATH"] = os.pathsep.join([str(venv / "bin"), environment.get("PATH", "")])
    cmake = str(venv / "bin/cmake")
    python = [f"-DPython3_EXECUTABLE={sys.executable}", f"-DPYTHON_EXECUTABLE={sys.executable}"]
    configure = [cmake, "-S", nodes, "-B", build, "-G", "Ninja", f"-DCMAKE_INSTALL_PREFIX={prefix}",
                 f"-DCAMWRIGHT_BINARY_DIR={binaries}", "-DBUILD_TESTING=OFF", *python]
    for command in (configure, [cmake, "--build", build, "--target", "install"]):
        done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        if done.returncode != 0:
            raise SystemExit(f"{' '.join(command)}: exit code {done.returncode}\n{done.stdout}")


main()
