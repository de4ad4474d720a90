# SPDX-License-Identifier: MIT
"""Four vivid devices as the cameras of a rig: 1280x800 grey at 30 Hz, black pictures without the driver's texts."""
import os

import fault_table
import glint_live_test
import guest_test

DEVICES = [f"/dev/video{number}" for number in range(4)]
MODULES = ["vivid n_devs=4 node_types=0x1,0x1,0x1,0x1 num_inputs=1,1,1,1 input_types=0x3,0x3,0x3,0x3"]
# The driver makes frames by the kernel's ticks of 4 ms: at 30 Hz it loses none of its own. The rate is that of CVT's
# pixel clock, 39 MHz for 1600x817 with all blanks.
RATE_HZ = 39e6 / (1600 * 817)
PERIOD_MS = 1e3 / RATE_HZ

RIG = f"""format = 1
kind = "rig"
[rig]
name = "four vivid devices"
rate_hz = {RATE_HZ:.4f}
calibration = "calibration.toml"
marker_radius_m = 0.0063
[capture]
format = "grey"
[capture.controls]
test_pattern = "100% Black"
osd_text_mode = "None"
"""


def faults_command(script, log):
    return f"vivid_faults --rate 30 --script {script} --log {log} --device {' '.join(DEVICES)} --"


def track_command(sets, out="/run/out"):
    return fault_table.track_command(",".join(DEVICES), sets, out)


def run(box, scripts, command, seconds=1500):
    """Runs a shell command in the guest; `scripts` are lines of vivid_faults by the names of their files."""
    glint_live_test.prepare(box, 2)
    for name, lines in {**scripts, "rig.toml": RIG.splitlines()}.items():
        with open(os.path.join(box, name), "w", encoding="utf-8") as file:
            file.writelines(f"{line}\n" for line in lines)
    names = ["rig.toml", "calibration.toml", *scripts, *[f"cam{n}.pgm" for n in range(1, 5)]]
    guest_test.run(["/bin/sh", "-c", command], modules=MODULES, out=box, seconds=seconds,
                   copy=[guest_test.program("vivid_faults"), *fault_table.programs(), *[f"{box}/{name}" for name in names]])
