#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Cameras hang and are unplugged, one at a time and each in its turn, while `glint track v4l2:` runs: it says so at once,
the others lose nothing, and the camera's frames are in the sets again soon after it is back."""
import tempfile

import fault_table
import glint_live_test
import guest_test

RATE_HZ, QUALITY, TICKS = 30, 80, 90  # what the guest's processor manages, see docs/device-tests.md
PERIOD_NS = 1e9 / RATE_HZ
EACH, FIRST = 20, 40  # the first 24 or so frames of each camera only teach its clock
SHORTEST, HANG_ROUND, UNPLUG_ROUND = 8, 32, 66  # pulses; outages of a pulse more each time
SAYS = {"hang": "gives no frames", "unplug": "was unplugged"}


def outages():
    """(kind, camera, pulses at which it begins, ends and is over)."""
    pulse = FIRST
    for kind, spacing in (("hang", HANG_ROUND), ("unplug", UNPLUG_ROUND)):
        for number in range(EACH):
            yield kind, 1 + number % 4, pulse, pulse + SHORTEST + number, pulse + spacing
            pulse += spacing


def script(planned):
    """A camera that hangs takes no pictures meanwhile."""
    for kind, camera, begins, ends, _ in planned:
        if kind == "hang":
            yield from (f"{pulse} {camera} never" for pulse in range(begins, ends))
        yield f"{begins} {camera} {kind}"
        yield f"{ends} {camera} {'resume' if kind == 'hang' else 'replug'}"


def main():
    verdict = guest_test.Verdict()
    planned = list(outages())
    pulses = planned[-1][-1]
    with tempfile.TemporaryDirectory() as box:
        glint_live_test.prepare(box, TICKS, RATE_HZ, QUALITY)
        with open(f"{box}/faults.txt", "w", encoding="utf-8") as file:
            file.writelines(f"{line}\n" for line in script(planned))
        names = ["rig.toml", "calibration.toml", "frames.jpgs", "faults.txt", *[f"cam{n}.pgm" for n in range(1, 5)]]
        devices = ",".join(f"$CAMERA_{n}" for n in range(1, 5))
        guest_test.run(
            [guest_test.program("uvc_cameras"), "--frames", "frames.jpgs", "--rate", str(RATE_HZ), "--pulses", str(pulses + 40),
             "--faults", "faults.txt", "--log", "/run/out/sent.csv", "--", "sh", "-c",
             fault_table.track_command(devices, pulses - FIRST + 20)],
            modules=guest_test.CAMERA_MODULES, copy=[*fault_table.programs(), *[f"{box}/{name}" for name in names]], out=box,
            seconds=1200)
        run = fault_table.Run(box)
        first_ns = min(row["time_ns"] for row in guest_test.read_csv(f"{box}/sent.csv"))

    table = fault_table.FaultTable(run, PERIOD_NS, verdict)
    table.quiet_before(first_ns + FIRST * PERIOD_NS)
    for kind, camera, *at in planned:
        table.add(fault_table.Fault(kind, [camera], *[first_ns + pulse * PERIOD_NS for pulse in at], SAYS[kind]))
    table.show()
    for kind, periods in (("hang", 4), ("unplug", 1)):
        latest_ms = max(table.rows[kind].noticed_ms, default=0)
        verdict.expect(latest_ms <= periods * PERIOD_NS / 1e6, f"{kind}: noticed only after {latest_ms} ms")
    verdict.finish()


if __name__ == "__main__":
    main()
