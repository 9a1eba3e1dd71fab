# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""Speed of `camwright study`: cases of the default job with 2, 1 and 4 workers, the first run killed in the middle and resumed.

    cargo build --release
    python3 tests/benchmarks/study_speed.py target/release/camwright [--cases 1000] [--workers 2 1 4]

Prints cases per second, peak memory and the hash of results.parquet of each run. Exits with 1 if the hashes differ.
"""

import argparse
import hashlib
import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path


def start(camwright, cases, workers, folder):
    design = f"design={{kind: sobol, samples: {cases}}}"
    words = ["study", "speed_and_infeed", "--set", design, "--workers", str(workers), "--out", folder]
    return subprocess.Popen([camwright, *words, "--quiet"])


def wait(process):
    """Exit code and peak memory (MB)."""
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return process.returncode, usage.ru_maxrss / 1024


def finished(folder):
    log = Path(folder, "cases.jsonl")
    return log.read_bytes().count(b"\n") if log.exists() else 0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("camwright")
    parser.add_argument("--cases", type=int, default=1000)
    parser.add_argument("--workers", type=int, nargs="+", default=[2, 1, 4])
    arguments = parser.parse_args()
    hashes = set()
    for workers in arguments.workers:
        with tempfile.TemporaryDirectory() as folder:
            begin = time.monotonic()
            note = ""
            if workers == arguments.workers[0]:
                killed = start(arguments.camwright, arguments.cases, workers, folder)
                while finished(folder) < arguments.cases // 2:
                    time.sleep(0.05)  # No event reaches this process from the file of another one.
                killed.send_signal(signal.SIGKILL)
                wait(killed)
                note = f", killed after {finished(folder)} cases"
            code, memory = wait(start(arguments.camwright, arguments.cases, workers, folder))
            seconds = time.monotonic() - begin
            assert code in (0, 4), f"exit code {code}"
            assert finished(folder) == arguments.cases, "a case is missing or ran twice"
            digest = hashlib.sha256(Path(folder, "results.parquet").read_bytes()).hexdigest()[:16]
            hashes.add(digest)
            rate = arguments.cases / seconds
            print(f"{workers} workers: {rate:.2f} cases/s, {memory:.0f} MB, results {digest}{note}", flush=True)
    return 0 if len(hashes) == 1 else 1


if __name__ == "__main__":
    sys.exit(main())
