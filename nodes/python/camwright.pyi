# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""Check, plan, simulate and study camwright jobs.

Jobs, machines, studies and lift tables are named as on the command line: by name (those that come with camwright) or by path.
`set` changes keys, as `--set` does: `plan("eccentric", set={"work_speed_rpm": 60, "infeed.spark_out_turns": 3})`.
Names of numbers end in their unit. No function needs ROS, and all of them release the interpreter lock while they compute.
"""

import os
from collections.abc import Iterator
from typing import Any, TypedDict

import numpy as np
from numpy.typing import NDArray

__version__: str

type Path = str | os.PathLike[str]
type Value = None | bool | int | float | str | list[Value] | dict[str, Value]
type Settings = dict[str, Value]

class InputError(ValueError):
    """A job, machine, study or table that cannot be used. Its text has all errors; the attributes are those of the first."""

    file: str
    line: int | None
    message: str

class SimulationError(RuntimeError):
    """A simulated job that made no part."""

    job: str
    reason: str
    alarm: int | None
    """Number of the alarm that stopped the machine."""

class Finding:
    """A finding: what, how much, how much is allowed, and where."""

    severity: str
    """`error` or `warning`."""
    file: str
    line: int | None
    message: str

class CheckReport:
    """Findings of a file, errors first."""

    file: str
    is_ok: bool
    """There is no error; there may be warnings."""
    findings: list[Finding]
    summary: str | None
    """One sentence about the job, if it can be made."""
    notes: list[str]

class Table:
    """Columns of equal length by name: `table["x_mm"]`. `pandas.DataFrame(dict(table))` makes a data frame of it."""

    units: dict[str, str]
    """Unit of each column, empty for a number."""
    def __getitem__(self, name: str) -> NDArray[np.float64]: ...
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[str]: ...
    def __contains__(self, name: object) -> bool: ...
    def keys(self) -> list[str]: ...
    def values(self) -> list[NDArray[np.float64]]: ...
    def items(self) -> list[tuple[str, NDArray[np.float64]]]: ...

class Plan:
    """A planned job."""

    job: str
    machine: str
    source: str
    """Text of the job file, with `set` applied."""
    plan_hash: str
    job_hash: str
    duration_s: float
    """Predicted duration of the whole job, homing included."""
    lobes: list[str]
    """Names of what the job makes one after the other: its lobes, or the part that it turns."""
    warnings: list[Finding]
    summary: dict[str, Any]
    """Content of the `summary.json` of `camwright plan`."""
    table_names: list[str]
    """Names of its tables, for example `A/speed_plan`: the CSV files of `camwright plan`."""
    def table(self, name: str) -> Table:
        """Returns one of its tables."""
    def write(self, folder: Path, *, plots: bool = False) -> list[str]:
        """Writes the files of `camwright plan --out`, with drawings on request; returns their paths."""
    def simulate(self) -> Simulation:
        """Makes the part on the simulated machine and measures it."""

class Simulation:
    """A part that the simulated machine made."""

    job: str
    results: dict[str, float | None]
    """Results of the whole part, for example `form_error_max_um`; None where the job has no such result."""
    units: dict[str, str]
    """Unit of each result, empty for a number."""
    worst_lobe: str | None
    """Lobe with the largest form error."""
    lobes: dict[str, dict[str, float]]
    """Results of each ground lobe."""
    def form(self, lobe: str | None = None) -> Table:
        """Form error of a lobe over the azimuth of the part, or of a turned surface over azimuth and z; positive where material is left."""

class CaseResult(TypedDict):
    """Row of a study."""

    case: int
    hash: str
    status: str
    reason: str
    alarm: int | None
    worst_lobe: str | None
    form_error_max_um: float | None
    lift_error_pv_um: float | None
    waviness_um: float | None
    job_time_s: float | None
    power_max_w: float | None
    burn_index: float | None
    alarms: float | None

def check(name: Path, *, set: Settings | None = None) -> CheckReport:
    """Checks a job, a machine, a study or a lift table; returns all findings."""

def plan(job: Path, *, set: Settings | None = None) -> Plan:
    """Plans a job. Raises InputError if it cannot be made."""

def simulate(job: Plan | Path, *, set: Settings | None = None) -> Simulation:
    """Makes the part of a job or of a plan on the simulated machine and measures it. Raises SimulationError if the machine stops."""

def plan_study(file: Path, folder: Path, *, set: Settings | None = None) -> list[str]:
    """Writes `plan.json` of a study into a folder; returns the hash of every case."""

def run_case(file: Path, folder: Path, case: str, *, set: Settings | None = None) -> CaseResult:
    """Runs a case of a written plan and writes its row into `cases/` of the folder. A case that has its row does not run again.

    A scheduler calls it on as many computers as it likes; `camwright study FILE --out FOLDER` collects the rows.
    """
