#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""`glint track v4l2:` on four virtual UVC cameras gives the points that reading the same pictures from files gives.

Slow motion: pictures of a rig at 90 Hz are shown at 5 Hz, because the guest's processor does one instruction a
nanosecond and takes 3 to 4 ms to decode a JPEG. Both runs have the same background pictures, so that nothing is learnt from different frames."""
import csv
import json
import math
import os
import shutil
import subprocess
import tempfile

import guest_test

TICKS, RATE_HZ, QUALITY = 90, 5, 90
WANTED_SETS = 50
MOST_APART_M = 50e-6  # 0.02 px at 2.5 m

RIG = """format = 1
kind = "rig"
[rig]
name = "four virtual cameras"
rate_hz = {rate_hz}.0
calibration = "calibration.toml"
marker_radius_m = 0.0063
[capture]
format = "mjpeg"
rate_hz = 90.0
"""


def glint(*arguments):
    subprocess.run([guest_test.program("glint"), *arguments], check=True)


def points_of(path):
    """Points by tick, and the time of each tick."""
    points, times_ns = {}, {}
    with open(path, encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            tick = int(row["tick"])
            points.setdefault(tick, []).append(tuple(float(row[axis]) for axis in ("x_m", "y_m", "z_m")))
            times_ns[tick] = int(row["time_ns"])
    return points, times_ns


def prepare(box, ticks, rate_hz=RATE_HZ, quality=QUALITY):
    """Pictures, background pictures and rig file; returns the folder with the pictures."""
    take, dark = os.path.join(box, "take"), os.path.join(box, "dark")
    jpeg = ["--jpeg", str(quality), "--rate", "90"]
    glint("sim", "--out", take, "--seconds", str(ticks / 90), *jpeg)
    glint("sim", "--out", dark, "--seconds", str(1 / 90), "--markers", "0", *jpeg)
    os.remove(os.path.join(take, "frames.csv"))  # times are those of the rig file's rate
    for camera in range(1, 5):
        shutil.copy(f"{dark}/cam{camera}/000000.pgm", f"{box}/cam{camera}.pgm")
    shutil.copy(f"{take}/calibration.toml", box)
    with open(f"{box}/rig.toml", "w", encoding="utf-8") as file:
        file.write(RIG.format(rate_hz=rate_hz))
    guest_test.make_frames(f"{box}/frames.jpgs", ticks, quality)
    return take


def track_live(box, sets, faults=(), rate_hz=RATE_HZ, options=""):
    """Points of the live run by pulse, and its summary. `options` are more of glint's."""
    with open(f"{box}/faults.txt", "w", encoding="utf-8") as file:
        file.writelines(f"{line}\n" for line in faults)
    names = ["rig.toml", "calibration.toml", "frames.jpgs", "faults.txt", *[f"cam{camera}.pgm" for camera in range(1, 5)]]
    track = ("glint track v4l2:$CAMERA_1,$CAMERA_2,$CAMERA_3,$CAMERA_4 --rig rig.toml --device cpu --background /run/job "
             f"--ticks {sets} {options} --quiet --output csv:/run/out/live.csv --summary /run/out/live.json")
    guest_test.run(
        [guest_test.program("uvc_cameras"), "--frames", "frames.jpgs", "--rate", str(rate_hz), "--pulses",
         str(sets + 100), "--faults", "faults.txt", "--log", "/run/out/sent.csv", "--", "sh", "-c", f"glint doctor --json > /run/out/doctor.json; {track}"],
        modules=guest_test.CAMERA_MODULES, copy=[guest_test.program("glint"), *[f"{box}/{name}" for name in names]], out=box,
        seconds=max(guest_test.HOST_SECONDS, sets))
    points, times_ns = points_of(f"{box}/live.csv")
    first_ns = min(row["time_ns"] for row in guest_test.read_csv(f"{box}/sent.csv"))
    # A frame is stamped after its pulse, and before the next.
    with open(f"{box}/live.json", encoding="utf-8") as file:
        summary = json.load(file)
    return {math.floor((times_ns[tick] - first_ns) * 1e-9 * rate_hz): points[tick] for tick in points}, summary


def track_files(box, take):
    """Points by tick of the same pictures, read from files."""
    glint("track", f"images:{take}", "--rig", f"{box}/rig.toml", "--device", "cpu", "--background", box, "--quiet",
          "--output", f"csv:{box}/file.csv")
    return points_of(f"{box}/file.csv")[0]


def check_doctor(verdict, box):
    """Four cameras that can be opened and share a bus; no Vulkan, which stops nothing."""
    with open(f"{box}/doctor.json", encoding="utf-8") as file:
        doctor = json.load(file)
    found = {finding["check"]: finding for finding in doctor["findings"]}
    verdict.expect(doctor["problems"] == 0, f"glint doctor sees problems: {doctor}")
    verdict.expect(found["cameras"]["text"].count("/dev/video") == 4, f"glint doctor: {found['cameras']}")
    verdict.expect("usb" in found and found["usb"]["verdict"] == "warning", "glint doctor says nothing of the shared bus")


def check_times(verdict, summary):
    """Latency from the driver's stamps and what was obtained of real time (the guest's user is root)."""
    latency, error = summary["stamp_to_output"], summary["time_error"]
    print(f"driver's stamp ({latency['stamp']}) to output: p50 {latency['p50_s'] * 1e3:.1f} ms, p99 "
          f"{latency['p99_s'] * 1e3:.1f} ms, max {latency['max_s'] * 1e3:.1f} ms; time of exposure known to "
          f"{error['p50_s'] * 1e3:.2f} ms; real time: {summary['real_time']}")
    verdict.expect(latency["count"] == summary["ticks"] == error["count"], "not every tick has a latency")
    verdict.expect(0 < latency["p50_s"] < 1 / RATE_HZ, "a latency of more than a period")
    real_time = summary["real_time"]
    verdict.expect(real_time["refusal"] == "" and real_time["memory_locked"], "real time was refused to root")
    for thread in real_time["threads"]:
        verdict.expect(0 < thread["started"] == thread["fifo"], f"a thread without SCHED_FIFO: {thread}")


def main():
    verdict = guest_test.Verdict()
    with tempfile.TemporaryDirectory() as box:
        from_files = track_files(box, prepare(box, TICKS))
        live, summary = track_live(box, WANTED_SETS)
        check_doctor(verdict, box)
    check_times(verdict, summary)
    compared = worst = same = 0
    for pulse, points in sorted(live.items()):
        verdict.expect(pulse in from_files, f"pulse {pulse} is in no file")
        for point in points:
            apart = min((math.dist(point, other) for other in from_files.get(pulse, [])), default=math.inf)
            compared += 1
            same += apart == 0
            worst = max(worst, apart)
            verdict.expect(apart <= MOST_APART_M, f"pulse {pulse}: a point {apart} m from the nearest of the file run")
        # New tracks are confirmed after some frames, so the first sets of a run hold fewer.
        if pulse >= min(live) + 5:
            verdict.expect(len(points) == len(from_files.get(pulse, [])),
                           f"pulse {pulse}: {len(points)} points, {len(from_files.get(pulse, []))} in the file run")
    print(f"{len(live)} pulses, {compared} points, {same} of them the same to the last digit, worst {worst * 1e6:.3f} um apart")
    verdict.expect(len(live) >= WANTED_SETS - 5, f"only {len(live)} frame sets have points")
    verdict.finish()


if __name__ == "__main__":
    main()
