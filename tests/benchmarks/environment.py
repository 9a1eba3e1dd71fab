# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""The Python environment of the benchmarks, under target/benchmarks, made once."""

import hashlib
import os
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
WORK = ROOT / "target" / "benchmarks"


def build(example):
    """Builds an example of the core in release; its path."""
    subprocess.run(["cargo", "build", "--quiet", "--release", "-p", "camwright", "--example", example], cwd=ROOT, check=True)
    return Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release" / "examples" / example


def enter(script):
    """Runs the script in the environment, in this process, if it does not run there already."""
    requirements = HERE / "requirements.txt"
    wanted = hashlib.sha256(requirements.read_bytes()).hexdigest()
    stamp, python = WORK / "stamp", WORK / "venv" / "bin" / "python"
    if not (stamp.is_file() and stamp.read_text(encoding="utf-8") == wanted and python.is_file()):
        print("making the environment in target/benchmarks/venv", flush=True)
        stamp.unlink(missing_ok=True)
        subprocess.run([sys.executable, "-m", "venv", "--clear", WORK / "venv"], check=True)
        pip = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "--no-deps", "-r", requirements]
        subprocess.run(pip, check=True)
        stamp.write_text(wanted, encoding="utf-8")
    if Path(sys.prefix).resolve() != python.parent.parent.resolve():
        threads = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")}
        os.execve(str(python), [str(python), str(Path(script).resolve()), *sys.argv[1:]], {**os.environ, **threads})
