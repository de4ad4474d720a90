#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""`glint track` with the simulated sync board and four virtual UVC cameras that the board triggers, on a real kernel:
1,000 frame sets are paired by the board's trigger numbers while frames go wrong. GLINT_FIRMWARE names the firmware."""
import json
import math
import os
import random
import subprocess
import sys
import tempfile

from board_server import BoardServer

HERE = os.path.dirname(os.path.abspath(__file__))
DEVICE_TESTS = os.path.join(os.path.dirname(HERE), "device")
sys.path.insert(0, DEVICE_TESTS)
import glint_live_test  # noqa: E402  (its folder is known only now)
import glint_long_test  # noqa: E402
import guest_test  # noqa: E402

SETS, RATE_HZ, QUALITY = 1000, 10, 80  # what this machine simulates in real time, with room
FIRST = 30  # the first 24 or so frames of each camera only teach its clock
SHARES = {"never": 0.02, "twice": 0.01, "truncated": 0.01, "error-bit": 0.01, "toggle": 0.005}
SYNC = """[sync]
board = "auto"
trigger_us = 100.0
strobe_us = 137.0
strobe_delay_us = 788.0
"""


def injected():
    """Lines PULSE CAMERA FAULT."""
    chance = random.Random(3)
    return [f"{pulse} {camera} {fault}" for pulse in range(FIRST, SETS) for camera in range(1, 5)
            for fault in chance.choices([None, *SHARES], [1 - sum(SHARES.values()), *SHARES.values()]) if fault]


def run_in_guest(box, boards):
    names = ["rig.toml", "calibration.toml", "frames.jpgs", "faults.txt", *[f"cam{camera}.pgm" for camera in range(1, 5)]]
    words = [sys.executable, os.path.join(DEVICE_TESTS, "run_in_guest.py"), "--network", "--timeout", "900", "--out", box]
    for module in ("vhci-hcd", "uvcvideo", "usbhid", "hid-generic"):
        words += ["--module", module]
    for path in [guest_test.program("glint"), guest_test.program("uvc_cameras"), *[f"{box}/{name}" for name in names]]:
        words += ["--copy", path]
    track = ("glint track v4l2:$CAMERA_1,$CAMERA_2,$CAMERA_3,$CAMERA_4 --rig rig.toml --device cpu --background /run/job "
             f"--ticks {SETS} --realtime off --output csv:/run/out/live.csv --summary /run/out/live.json")
    words += ["--", guest_test.program("usbip_attach"), "--port", str(boards.port), "--first-port", "4", "--",
              "uvc_cameras", "--frames", "frames.jpgs", "--pulses", str(2 * SETS), "--faults", "faults.txt",
              "--board", f"10.0.2.2:{boards.control_port}", "--read-out", "20", "--log", "/run/out/sent.csv",
              "--", "sh", "-c", track]
    code = subprocess.run(words, check=False).returncode
    if code != 0:
        sys.exit(code if code == guest_test.SKIPPED else 1)


def main():
    firmware = os.environ.get("GLINT_FIRMWARE")
    if not firmware:
        print("SKIPPED: GLINT_FIRMWARE names no firmware (needs gcc-arm-none-eabi when configuring)")
        sys.exit(guest_test.SKIPPED)
    verdict = guest_test.Verdict()
    faults = injected()
    with tempfile.TemporaryDirectory() as box, BoardServer(firmware) as boards:
        take = glint_live_test.prepare(box, glint_long_test.TICKS, RATE_HZ, QUALITY)
        with open(f"{box}/rig.toml", "a", encoding="utf-8") as file:
            file.write(SYNC)
        with open(f"{box}/faults.txt", "w", encoding="utf-8") as file:
            file.writelines(f"{line}\n" for line in faults)
        from_files = glint_live_test.track_files(box, take)
        boards.ask("watch 6")
        run_in_guest(box, boards)
        status, light = boards.ask("status"), boards.ask("edges 6")
        live = glint_live_test.points_of(f"{box}/live.csv")[0]
        with open(f"{box}/live.json", encoding="utf-8") as file:
            summary = json.load(file)
    board = summary["sync_board"]
    print(f"{len(faults)} faults; board: {board}")
    wrong = far_points = points = expected = 0
    for trigger, found in live.items():
        others = from_files.get(glint_long_test.shown(trigger), [])
        far = sum(min((math.dist(point, other) for other in others), default=math.inf) > 2e-3 for point in found)
        wrong += 4 * far >= len(found)
        far_points, points, expected = far_points + far, points + len(found), expected + len(others)
    print(f"{len(live)} sets with points, {wrong} paired wrongly; {points} points for {expected} of the file run, "
          f"{far_points} of them elsewhere; {summary['ledger']}")
    verdict.expect(summary["ticks"] == SETS, f"{summary['ticks']} frame sets")
    verdict.expect(len(live) > 0.98 * SETS, f"only {len(live)} frame sets have points")
    verdict.expect(wrong == 0, f"{wrong} sets are paired wrongly")
    verdict.expect(points > 0.95 * expected, f"{points} points, {expected} in the file run")
    verdict.expect(board["not_told"] == board["not_taken"] == board["gone"] == 0, f"the board's pulses: {board}")
    verdict.expect(not status["complaints"] and len(status["resets"]) == 1, f"the board says {status}")
    verdict.expect(len(light) > 2 * SETS and light[-1][1] == 0, "the strobes did not flash, or are left on")
    verdict.finish()


if __name__ == "__main__":
    main()
