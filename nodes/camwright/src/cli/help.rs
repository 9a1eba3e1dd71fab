// Copyright 2026 The camwright maintainers. SPDX-License-Identifier: Apache-2.0
//! Examples and exit codes at the end of each command's help.

pub(super) const CAMWRIGHT: &str = "\
Examples:
  camwright                         # run the default job
  camwright check my_job.yaml       # validate a job
  camwright run --help              # help of a command

ROS arguments work with every command, after --ros-args:
  camwright status --ros-args -r __ns:=/cell_2

Exit codes: 0 done, 2 wrong arguments, others by command (see its help)";

pub(super) const RUN: &str = "\
Examples:
  camwright run four_lobe_camshaft --details --causes
  camwright run my_job.yaml --set work_speed_rpm=58 --bag bags/slow

A cell of separate processes has the nodes machine_sim, axis_interpolator,
job_planner and, for recording, run_logger. They lie beside the program
camwright; a package installs them in lib/camwright. Start them, then run jobs
with --attach. `machine_sim --help` shows their options.

Exit codes:
  0    complete and within tolerance, or dry run complete
  1    not started or rejected
  2    wrong arguments
  3    cancelled or ended by an alarm
  4    out of tolerance or burnt
  70   DDS failed in this process
  101  a thread of the program panicked";

pub(super) const PLAN: &str = "\
Example: camwright plan four_lobe_camshaft --out plan --plots

Files: summary.json; per lobe lift.csv, contour.csv, tool_path.csv and
speed_plan.csv, with the key `pulses` also pulses.csv; for a turned part
surface.csv, clearance.csv and per pass insert_path.csv

Exit codes: 0 planned and written, 2 rejected or not written";

pub(super) const TRACE: &str = "\
Example: camwright trace four_lobe_camshaft --lobe I1 --c 143.2 --turn 2

Exit codes: 0 traced, 2 rejected";

pub(super) const LEARN: &str = "\
Examples:
  camwright learn four_lobe_camshaft --report I1=gauge_I1.csv \
    --report E1=gauge_E1.csv --align eccentricity --out second_part.yaml
  camwright learn second_part.yaml --report I1=gauge_I1b.csv \
    --columns cam_angle_deg,deviation_um --out third_part.yaml

A report is a table of text: deviation_um, deviation_mm or deviation_inch over
cam_angle_deg (along the normal, positive where material is left); lift_mm or
lift_inch over cam_angle_deg or crank_angle_deg (for the follower of the job);
or radius_mm over azimuth_deg from the keyway, or x_mm and y_mm. Lifts say
nothing about the size.

Without --align, size, eccentricity and phase count as errors of the part and
are corrected with the form.

Exit codes: 0 written, 2 rejected or not written";

pub(super) const STUDY: &str = "\
Examples:
  camwright study speed_and_infeed --out studies/first
  camwright study my_study.yaml --workers 2 --set replicates=3
  camwright study my_study.yaml --minimise job_time_s \
    --subject-to 'form_error_max_um<=3,burn_index<=0.9'
  camwright study my_study.yaml --plan --out shared
  camwright study my_study.yaml --case 0123456789abcdef --out shared

--minimise searches from the best cases of the design, at most 4 times, with
COBYLA, which needs no derivatives. It moves the factors with ranges; lists keep
their values. It ends with best_job.yaml, a job file that makes the best part.

Several computers: --plan writes the cases, --case runs one of them anywhere,
and the command without both collects cases/*.json and writes the results.

Files: plan.json (every case with its hash), cases.jsonl (finished cases),
results.parquet, results.csv, report.html; best_job.yaml and best_machine.yaml
of the best feasible case. The same command goes on after an interruption and
runs no case twice.

Exit codes:
  0    a case is feasible
  1    not written
  2    rejected
  4    no case is feasible
  130  interrupted by Ctrl-C";

pub(super) const POST: &str = "\
Examples:
  camwright post four_lobe_camshaft --out nc --set nc.control=fanuc
  camwright post --eccentric 4.2 --diameter 38 --tool-radius 15 --out nc
  camwright post turned_cam --out nc --set nc.finish_tolerance_um=1

Exit codes: 0 written and verified, 2 rejected or not written";

pub(super) const INIT: &str = "\
Examples:
  camwright init job
  camwright init machine my_grinder.yaml
  camwright init turning --print
  camwright init study

Exit codes: 0 written or printed, 1 not written, 2 wrong arguments";

pub(super) const LIST: &str = "\
Examples:
  camwright list jobs
  camwright list alarms --json

Exit codes: 0 printed, 1 a file of params is refused, 2 wrong arguments";

pub(super) const CHECK: &str = "\
Examples:
  camwright check four_lobe_camshaft
  camwright check my_machine.yaml
  camwright check nodes.yaml

Exit codes: 0 clean, 1 warnings, 2 rejected or not found";

pub(super) const CHECK_MACHINE: &str = "\
Examples:
  camwright check-machine
  camwright check-machine --move z_axis --distance 2

Exit codes:
  0    no clause is broken
  1    a clause is broken
  2    wrong arguments
  3    no machine found
  4    the machine must not be moved now
  130  interrupted by Ctrl-C";

pub(super) const DRIVES: &str = "\
Example: camwright drives turned_cam --set turned.to_mm=20 --tolerance-um 2

Exit codes: 0 done, 2 rejected, or not a turning job";

pub(super) const CHATTER: &str = "\
Examples:
  camwright chatter journal_runout
  camwright chatter my_job.yaml --variation 20 --period 2.5 --plot lobes.svg

Growth is the factor of the worst wave per turn; above 1 it grows. The machine
file states what vibrates: the drive of x_axis, and contact.modes of a tap test.

Exit codes: 0 stable, 1 a pass chatters, 2 rejected or not written";

pub(super) const HOLD: &str = "\
Example: camwright hold

Open to everyone; `camwright resume` continues.

Exit codes: 0 done, 2 wrong arguments, 3 refused or no cell";

pub(super) const RESUME: &str = "\
Example: camwright resume

Exit codes: 0 done, 2 wrong arguments, 3 refused or no cell";

pub(super) const OVERRIDE: &str = "\
Example: camwright override 50%

Exit codes: 0 done, 2 wrong arguments, 3 refused or no cell";

pub(super) const CANCEL: &str = "\
Example: camwright cancel

Open to everyone. The axes come to rest; the part stays as it is.

Exit codes: 0 done, 2 wrong arguments, 3 refused or no cell";

pub(super) const RESET: &str = "\
Example: camwright reset

`camwright status` lists the alarms and their remedies.

Exit codes: 0 done, 2 wrong arguments, 3 refused or no cell";

pub(super) const ESTOP: &str = "\
Examples:
  camwright estop
  camwright estop --release

Open to everyone; the release needs command. A simulation, not a safety function.

Exit codes: 0 done, 2 wrong arguments, 3 refused or no cell";

pub(super) const FAULT: &str = "\
Examples:
  camwright fault drive_fault x_axis
  camwright fault drive_fault x_axis --clear
  camwright fault encoder_offset z_axis --value 0.0001

`camwright list faults` lists names, targets and units of the value. A fault at
a time of a job is the key `faults` of its file. Needs command.

Exit codes: 0 done, 2 wrong arguments, 3 refused or no cell";

pub(super) const HOME: &str = "\
Examples:
  camwright home
  camwright home x_axis z_axis

Exit codes: 0 done, 2 wrong arguments, 3 refused or no cell";

pub(super) const WHEEL: &str = "\
Example: camwright wheel on

Exit codes: 0 done, 2 wrong arguments, 3 refused or no cell";

pub(super) const LOAD: &str = "\
Example: camwright load

Exit codes: 0 done, 2 wrong arguments, 3 refused or no cell";

pub(super) const UNLOAD: &str = "\
Example: camwright unload

Exit codes: 0 done, 2 wrong arguments, 3 refused or no cell";

pub(super) const JOG: &str = "\
Examples:
  camwright jog z_axis=-0.5 --speed 2
  camwright jog x_axis --speed -1

Exit codes: 0 done, 2 wrong arguments, 3 refused or no cell";

pub(super) const SETUP: &str = "\
Examples:
  camwright setup move x_axis=120 c_axis=-45
  camwright setup find-phase --load-part

Exit codes: 0 done, 1 no cell or no command, 2 wrong arguments, 3 failed";

pub(super) const SETUP_MOVE: &str = "\
Examples:
  camwright setup move x_axis=120 c_axis=-45
  camwright setup move --by z_axis=-0.5 --speed-factor 0.1

Exit codes: 0 done, 1 no cell or no command, 2 wrong arguments, 3 failed";

pub(super) const SETUP_PROBE: &str = "\
Example: camwright setup probe x_axis=18.5 wheel_contact --stand-off 0.1

Exit codes: 0 done, 1 no cell or no command, 2 wrong arguments, 3 failed";

pub(super) const SETUP_DRESS: &str = "\
Example: camwright setup dress --depth-um 20

Exit codes: 0 done, 1 no cell or no command, 2 wrong arguments, 3 failed";

pub(super) const SETUP_CHANGE_WHEEL: &str = "\
Example: camwright setup change-wheel finishing

Exit codes: 0 done, 1 no cell or no command, 2 wrong arguments, 3 failed";

pub(super) const SETUP_TOUCH_OFF: &str = "\
Examples:
  camwright setup touch-off --lobe J1
  camwright setup touch-off --station LS1 --radius-mm 20

Exit codes: 0 done, 1 no cell or no command, 2 wrong arguments, 3 failed";

pub(super) const SETUP_FIND_PHASE: &str = "\
Example: camwright setup find-phase --load-part

Exit codes: 0 done, 1 no cell or no command, 2 wrong arguments, 3 failed";

pub(super) const PAGE: &str = "\
Example: camwright page --port 8080

Exit codes: 0 ended by Ctrl-C, 1 not started, 2 wrong arguments";

pub(super) const GATEWAY: &str = "\
Examples:
  camwright gateway
  camwright gateway --devices cam_grinder > Devices.xml
  camwright gateway --mtconnect-port 7879 --ros-args -r __ns:=/cell_2
  camwright gateway --opcua
  camwright gateway --opcua 4841 --manufacturer Example --serial-number 7

Load Devices.xml into an agent, and point its adapter at the printed address.
Ids of data items begin with the namespace of the cell, except in /.
OPC UA clients connect to the second printed address, without password.

Exit codes: 0 printed or ended by Ctrl-C, 1 not started, 2 wrong arguments";

pub(super) const STATUS: &str = "\
Examples:
  camwright status
  camwright status --watch
  camwright status --json --ros-args -r __ns:=/cell_2

Exit codes:
  0  no alarm; with --watch: ended by Ctrl-C
  1  no cell found
  2  wrong arguments
  3  an alarm needs a reset";

pub(super) const FLEET: &str = "\
Examples:
  camwright fleet status
  camwright fleet start four_lobe_camshaft --cell /cell_1 --cell /cell_2
  camwright fleet status --domain 11-30
  camwright fleet stop

A cell is a namespace in which a machine, an interpolator or a planner
publishes. `--domain` lists cells in several domains. Cells on other hosts need
ROS_AUTOMATIC_DISCOVERY_RANGE=SUBNET on every host.

Exit codes: by command, see `camwright fleet COMMAND --help`";

pub(super) const FLEET_STATUS: &str = "\
Examples:
  camwright fleet status
  camwright fleet status --watch
  camwright fleet status --json --cell /cell_1
  camwright fleet status --domain 11-30

Exit codes:
  0  every cell answers, none has an alarm; with --watch: ended by Ctrl-C
  1  no cell found
  2  wrong arguments
  3  an alarm of a cell needs a reset
  4  a cell does not answer, or a named domain has none";

pub(super) const FLEET_START: &str = "\
Examples:
  camwright fleet start four_lobe_camshaft
  camwright fleet start my_job.yaml --cell /cell_1 --set work_speed_rpm=58

Takes command of each idle cell, sends the job, and releases command once the
planner has accepted it. `camwright fleet status` shows the progress.

Exit codes:
  0  every cell accepted the job
  1  no cell found
  2  wrong arguments
  3  a cell is not idle or rejected the job
  4  a cell does not answer";

pub(super) const FLEET_STOP: &str = "\
Example: camwright fleet stop

Open to everyone. The axes come to rest; the parts stay as they are. A cell at
rest has nothing to stop.

Exit codes:
  0  every cell stops or is at rest
  1  no cell found
  2  wrong arguments
  3  a cell did not stop
  4  a cell does not answer";

pub(super) const URDF: &str = "\
Example: camwright urdf cam_grinder > cam_grinder.urdf

Exit codes: 0 printed, 1 rejected, 2 wrong arguments";

pub(super) const HAL: &str = "\
Examples:
  camwright hal --simulate > cam_grinder.hal
  camwright hal my_machine > my_machine.hal

Start it as an ordinary user with `halrun -I -f FILE.hal`, then the node:
  machine_hal --ros-args -p machine:=cam_grinder_hal

Exit codes: 0 printed, 1 rejected, 2 wrong arguments";

pub(super) const BAG: &str = "\
Examples:
  camwright bag info bags/my_run
  camwright bag check bags/my_run

Exit codes: by command, see `camwright bag COMMAND --help`";

pub(super) const BAG_INFO: &str = "\
Example: camwright bag info bags/my_run --details

Exit codes: 0 printed, 2 no readable bag";

pub(super) const BAG_CHECK: &str = "\
Example: camwright bag check bags/my_run

Exit codes: 0 clean, 1 warnings, 2 errors or no readable bag";

pub(super) const BAG_REPORT: &str = "\
Example: camwright bag report bags/my_run --out my_run.html

Exit codes: 0 written, 1 not written, 2 wrong arguments";

pub(super) const BAG_RECOVER: &str = "\
Example: camwright bag recover bags/my_run --into bags/my_run_2

Exit codes: 0 nothing lost, 1 no new bag, 2 something lost or wrong arguments";

pub(super) const BAG_EXPORT: &str = "\
Examples:
  camwright bag export bags/my_run --to parquet
  camwright bag export bags/my_run --to zstd_small --into small

Exit codes: 0 exported, 1 some topics not exported, 2 no readable bag";

pub(super) const REPLAY: &str = "\
Examples:
  camwright replay bags/my_run --rate 2
  camwright replay bags/my_run --against
  camwright replay bags/my_run --against bags/other_run

Exit codes of playing: 0 played or interrupted, 2 not played
Exit codes of --against: 0 identical, 1 cannot be computed, 3 different";

pub(super) const REPLAN: &str = "\
Example: camwright replan bags/my_run --set work_speed_rpm=58

Exit codes:
  0  same plans
  1  a job cannot be planned again
  2  wrong arguments
  3  differences";

pub(super) const COMPLETIONS: &str = "\
Examples:
  camwright completions zsh > ~/.zfunc/_camwright
  camwright completions fish > ~/.config/fish/completions/camwright.fish

Exit codes: 0 printed, 2 wrong arguments";

pub(super) const MAN: &str = "\
Example: camwright man ~/.local/share/man/man1

Exit codes: 0 written, 1 not written, 2 wrong arguments";
