# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""Speed of a cell of four processes at pace fast, and the processor time of each.

    cargo build --release -p camwright_nodes --bins
    python3 tests/benchmarks/cell_speed.py target/release [--runs 5]

`machine_sim`, `axis_interpolator`, `job_planner` and `run_logger` run as processes of their own; `camwright run --attach` runs the default
job. Prints the speed of each run, with the search for the nodes and without it (planning is part of both). For the median run it prints the
processor time of each process in user mode and in the kernel, and how often its threads waited.
"""

import argparse
import json
import os
import resource
import signal
import subprocess
import tempfile
from pathlib import Path

NODES = ["machine_sim", "axis_interpolator", "job_planner", "run_logger"]
PARAMETERS = {"machine_sim": ["pace:=fast", "state_file:=none"], "run_logger": ["bag_dir:=bag"]}
TICKS = os.sysconf("SC_CLK_TCK")


def usage(process):
    """Processor time in user mode and in the kernel (s), and voluntary waits of all threads."""
    user, system = Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[11:13]
    waits = 0
    for status in Path(f"/proc/{process}/task").glob("*/status"):
        waits += int(next(line for line in status.read_text().splitlines() if line.startswith("voluntary")).split()[1])
    return [int(user) / TICKS, int(system) / TICKS, waits]


def run(programs, domain):
    with tempfile.TemporaryDirectory() as folder:
        environment = dict(os.environ, ROS_DOMAIN_ID=str(domain), XDG_STATE_HOME=folder)
        nodes = {}
        for name in NODES:
            words = [str(programs / name), "--ros-args"]
            for parameter in PARAMETERS.get(name, []):
                words += ["-p", parameter]
            log = open(Path(folder, f"{name}.log"), "w", encoding="utf-8")
            nodes[name] = subprocess.Popen(words, cwd=folder, env=environment, stdout=log, stderr=log)
        try:
            command = [str(programs / "camwright"), "run", "--attach", "--json", "--timings"]
            first = {name: usage(node.pid) for name, node in nodes.items()}
            before = resource.getrusage(resource.RUSAGE_CHILDREN)
            done = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
            after = resource.getrusage(resource.RUSAGE_CHILDREN)
            if done.returncode != 0:
                raise SystemExit(f"{' '.join(command)}: exit code {done.returncode}\n{done.stdout}{done.stderr}")
            last = {name: usage(node.pid) for name, node in nodes.items()}
        finally:
            for node in nodes.values():
                node.send_signal(signal.SIGINT)
            for node in nodes.values():
                node.wait()
        bag = [str(programs / "camwright"), "bag", "info", "bag", "--json"]
        info = json.loads(subprocess.run(bag, cwd=folder, capture_output=True, text=True, check=True).stdout)
    used = {name: [b - a for a, b in zip(first[name], last[name])] for name in NODES}
    used["camwright"] = [after.ru_utime - before.ru_utime, after.ru_stime - before.ru_stime, after.ru_nvcsw - before.ru_nvcsw]
    ran_s = next(float(line.split()[-2]) for line in done.stderr.splitlines() if line.startswith("running the job"))
    result = json.loads(done.stdout)
    return result["duration_s"], result["took_s"], ran_s, info["message_count"], used


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("programs", type=Path)
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--domain", type=int, default=90)
    arguments = parser.parse_args()
    if arguments.runs < 1:
        parser.error("--runs must be 1 or more")
    programs = arguments.programs.resolve()
    missing = [name for name in [*NODES, "camwright"] if not (programs / name).is_file()]
    if missing:
        raise SystemExit(f"{programs} has no {', '.join(missing)}: cargo build --release -p camwright_nodes --bins")
    runs = sorted((run(programs, arguments.domain) for _ in range(arguments.runs)), key=lambda one: one[1] / one[0])
    for machine_s, took_s, ran_s, messages, _ in runs:
        whole, job = machine_s / took_s, machine_s / ran_s
        print(f"{machine_s:.1f} s of machine time, {messages} messages: with start {took_s:.2f} s, {whole:.1f} times real time; job {ran_s:.2f} s, {job:.1f} times")
    machine_s, took_s, _, messages, used = runs[len(runs) // 2]
    print(f"\nmedian run, {os.cpu_count()} cores\n\n| process | user s | kernel s | waits |\n|---|---:|---:|---:|")
    for name, (user, system, waits) in used.items():
        print(f"| `{name}` | {user:.2f} | {system:.2f} | {waits} |")
    user, system, waits = (sum(values) for values in zip(*used.values()))
    print(f"| in all | {user:.2f} | {system:.2f} | {waits} |")
    share = (user + system) / (took_s * os.cpu_count())
    print(f"\n{100 * share:.0f} % of the processor time of the run, {1e6 * (user + system) / messages:.0f} us for each recorded message")


main()
