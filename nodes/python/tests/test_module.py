# Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
"""Tests of the module `camwright` as a user has it: installed from its wheel."""

import csv
import pathlib
import re
import threading
import time

import camwright
import numpy as np
import pytest

PARAMS = pathlib.Path(__file__).parents[3] / "params"
SHORT = {"infeed.total_mm": 0.072, "stock_mm": 0.06}
LATHE = {"turned.from_mm": 24, "turned.to_mm": 22, "form_grid.azimuths": 180}

STUDY = """schema: camwright/study/1
name: small
job: eccentric
fixed: {infeed.total_mm: 0.036, stock_mm: 0.03}
factors: {infeed.spark_out_turns: [1, 2]}
design: {kind: grid}
seeds: [raw_part.seed]
"""


@pytest.fixture(scope="module")
def plan():
    return camwright.plan("four_lobe_camshaft", set=SHORT)


def test_a_plan_has_the_files_of_the_command_line_as_arrays(plan, tmp_path):
    assert (plan.job, plan.machine) == ("four_lobe_camshaft", "cam_grinder")
    assert len(plan.plan_hash) == 64 and plan.summary["plan_hash"] == plan.plan_hash
    assert plan.summary["duration_s"] == plan.duration_s
    assert "stock_mm: 0.06" in plan.source
    written = [pathlib.Path(path) for path in plan.write(tmp_path)]
    tables = [path for path in written if path.suffix == ".csv"]
    names = [path.relative_to(tmp_path).with_suffix("").as_posix() for path in tables]
    assert names == plan.table_names and f"{plan.lobes[0]}/speed_plan" in names
    for name, path in zip(names, tables):
        table = plan.table(name)
        with open(path, newline="") as file:
            header, *rows = csv.reader(file)
        assert list(table) == header and set(table.units) == set(header)
        values = np.array(rows, dtype=float)
        for index, column in enumerate(header):
            array = table[column]
            assert array.dtype == np.float64
            assert np.array_equal(array, values[:, index]), f"{name}: {column}"


def test_the_path_of_an_eccentric_is_that_of_its_closed_form():
    """The wheel's centre moves on a circle about the disc: x = e cos(a) + sqrt((r + R)^2 - e^2 sin^2(a))."""
    disc = camwright.plan("eccentric")
    x_mm = disc.table(f"{disc.lobes[0]}/tool_path")["x_mm"]
    # The extremes give e and r + R; the rest of the curve has to follow.
    eccentricity, distance = (x_mm.max() - x_mm.min()) / 2, (x_mm.max() + x_mm.min()) / 2
    angle = np.linspace(0, 2 * np.pi, len(x_mm), endpoint=False) - np.argmax(x_mm) * 2 * np.pi / len(x_mm)
    exact = eccentricity * np.cos(angle) + np.sqrt(distance**2 - (eccentricity * np.sin(angle)) ** 2)
    assert np.abs(x_mm - exact).max() < 1e-5


def test_the_derivatives_of_the_lift_are_those_of_its_values(plan):
    lift = plan.table(f"{plan.lobes[0]}/lift")
    assert lift.units["lift_mm_rad"] == "mm/rad"
    step = np.radians(lift["cam_angle_deg"][1])
    slope = (np.roll(lift["lift_mm"], -1) - np.roll(lift["lift_mm"], 1)) / (2 * step)
    assert np.abs(slope - lift["lift_mm_rad"]).max() < 1e-3 * np.abs(lift["lift_mm_rad"]).max()


def test_a_simulated_part_has_results_by_lobe_and_its_form_as_arrays(plan):
    part = plan.simulate()
    assert set(part.lobes) == set(plan.lobes) and part.worst_lobe in part.lobes
    assert set(part.units) == set(part.results) and part.units["form_error_max_um"] == "um"
    largest = {name: np.abs(part.form(name)["form_error_um"]).max() for name in plan.lobes}
    for name, lobe in part.lobes.items():
        assert abs(lobe["form_error_max_um"]) == pytest.approx(largest[name], abs=1e-9)
        rms = np.sqrt(np.mean(part.form(name)["form_error_um"] ** 2))
        assert lobe["form_error_rms_um"] == pytest.approx(rms, abs=1e-9)
    assert part.results["form_error_max_um"] == pytest.approx(max(largest.values()), abs=1e-9)
    assert part.results["job_time_s"] == pytest.approx(plan.duration_s, rel=0.1)
    again = camwright.simulate("four_lobe_camshaft", set=SHORT)
    assert again.results == part.results, "the same input gives the same bits"


def test_a_turned_surface_is_one_table():
    plan = camwright.plan("turned_cam", set=LATHE)
    assert plan.table_names[-1] == "clearance" and len(plan.table("clearance")["clearance_deg"]) == 360
    part = plan.simulate()
    form = part.form()
    error = form["form_error_um"].reshape(-1, 180)
    assert np.array_equal(form["z_mm"].reshape(error.shape)[:, 0], np.unique(form["z_mm"]))
    assert np.abs(error).max() == pytest.approx(part.results["form_error_max_um"], abs=1e-9)
    assert part.results["burn_index"] is None and part.lobes == {}
    with pytest.raises(KeyError, match="call form\\(\\) without a lobe"):
        part.form("A")


def test_values_are_set_as_on_the_command_line(plan):
    numbers = {"infeed.total_mm": np.float64(0.072), "stock_mm": np.float32(0.0625), "infeed.spark_out_turns": np.int64(3)}
    source = camwright.plan("four_lobe_camshaft", set=numbers).source
    assert "0.072" in source and "0.0625" in source
    laws = [{"law": "dwell", "angle_deg": 220}, {"law": "4-5-6-7", "angle_deg": 70, "rise_deg": 7}]
    laws.append({"law": "4-5-6-7", "angle_deg": 70, "rise_deg": -7})
    follower = {"kind": "oscillating_roller", "radius_mm": 8.5, "arm_mm": 42, "pivot_mm": 48, "side": "behind"}
    keys = {"base_radius_mm": 16, "follower": follower, "lift": {"segments": tuple(laws)}}
    swing = camwright.plan("eccentric", set={f"profiles.eccentric.{key}": value for key, value in keys.items()} | {"work_speed_rpm": 30})
    assert swing.table(f"{swing.lobes[0]}/lift")["lift_mm"].max() == pytest.approx(np.radians(7) * 42, rel=1e-6)
    with pytest.raises(TypeError, match="stock_mm is a object"):
        camwright.plan("eccentric", set={"stock_mm": object()})
    with pytest.raises(TypeError, match="key 3 is no text"):
        camwright.plan("eccentric", set={3: 1})
    with pytest.raises(ValueError, match="stock_mm is NaN; a finite number is needed"):
        camwright.plan("eccentric", set={"stock_mm": float("nan")})
    with pytest.raises(TypeError, match="a plan is complete"):
        camwright.simulate(plan, set={"stock_mm": 1})


def test_errors_have_file_and_line(tmp_path):
    source = camwright.plan("eccentric").source
    job = tmp_path / "wrong.yaml"
    lines = [f"{line.split(':')[0]}: -1" if line.startswith("stock_mm") else line for line in source.splitlines()]
    job.write_text("\n".join(lines) + "\n")
    line = next(number for number, text in enumerate(lines, 1) if text == "stock_mm: -1")
    with pytest.raises(camwright.InputError, match="stock_mm is -1") as error:
        camwright.plan(job)
    assert isinstance(error.value, ValueError)
    assert (error.value.file, error.value.line) == (str(job), line)
    assert error.value.message.startswith("stock_mm is -1") and str(error.value).startswith(f"{job}:{line}: ")
    report = camwright.check(job)
    assert not report.is_ok and (report.findings[0].severity, report.findings[0].line) == ("error", line)
    with pytest.raises(camwright.InputError, match="did you mean eccentric"):
        camwright.plan("ecentric")
    with pytest.raises(KeyError, match="has no table 'nothing'|has no table \"nothing\""):
        camwright.plan("eccentric").table("nothing")


def test_an_alarm_is_an_exception_with_its_number(tmp_path):
    """The X axis of this machine trips at a following error of 1.1 um."""
    text = (PARAMS / "machines/cam_grinder.yaml").read_text()
    before, x_axis = text.split("x_axis:", 1)
    for key, value in [("min_following_error_mm", "0.001"), ("max_following_error_mm", "0.0011")]:
        x_axis, count = re.subn(rf"(\b{key}: *)[0-9.]+", rf"\g<1>{value}", x_axis, count=1)
        assert count == 1
    machine = tmp_path / "strict.yaml"
    machine.write_text(f"{before}x_axis:{x_axis}")
    with pytest.raises(camwright.SimulationError, match="following error") as error:
        camwright.simulate("eccentric", set={"machine": str(machine)})
    assert isinstance(error.value, RuntimeError)
    assert (error.value.job, error.value.alarm) == ("eccentric", 32)
    assert error.value.reason in str(error.value)


def test_the_interpreter_lock_is_free_while_a_job_is_computed():
    """Another thread counts on while a job is planned and simulated."""
    counted, stop = [0], threading.Event()

    def count():
        while not stop.is_set():
            counted[0] += 1
            time.sleep(0)

    thread = threading.Thread(target=count)
    thread.start()
    before = counted[0]
    camwright.simulate("four_lobe_camshaft", set=SHORT)
    during = counted[0] - before
    stop.set()
    thread.join()
    assert during > 1000, f"the other thread came {during} times to its turn"


def test_cases_of_a_study_run_alone_and_not_twice(tmp_path):
    file, folder = tmp_path / "small.yaml", tmp_path / "out"
    file.write_text(STUDY)
    hashes = camwright.plan_study(file, folder)
    assert len(hashes) == 2 and (folder / "plan.json").is_file()
    rows = [camwright.run_case(file, folder, name) for name in hashes]
    assert [row["case"] for row in rows] == [1, 2] and {row["status"] for row in rows} == {"done"}
    written = sorted(path.stat().st_mtime_ns for path in (folder / "cases").iterdir())
    assert [camwright.run_case(file, folder, name) for name in hashes] == rows
    assert sorted(path.stat().st_mtime_ns for path in (folder / "cases").iterdir()) == written
    with pytest.raises(camwright.InputError, match="the plan has no such case"):
        camwright.run_case(file, folder, "0" * 16)
    with pytest.raises(camwright.InputError, match="write the plan of the cases first"):
        camwright.run_case(file, tmp_path / "nothing", hashes[0])
    with pytest.raises(camwright.InputError, match="have changed since the plan was written"):
        camwright.run_case(file, folder, hashes[0], set={"fixed.stock_mm": 0.031})
