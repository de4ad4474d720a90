# SPDX-License-Identifier: MIT
"""What the tests in the guest share: building the command, skipping, reading what came out."""
import csv
import os
import shutil
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
SKIPPED = 77
LOOPBACK_NODES = [f"/dev/video{number}" for number in range(40, 44)]
LOOPBACK_MODULE = "v4l2loopback devices=4 video_nr=40,41,42,43 exclusive_caps=0,0,0,0 max_buffers=16"
CAMERA_MODULES = ["vhci-hcd", "uvcvideo"]
HOST_SECONDS = 400.0  # a shared machine may be busy; the guest's own time is not touched by that


def program(name):
    """Path of a built program; CTest says where they are."""
    folders = os.environ.get("GLINT_DEVICE_PROGRAMS")
    if not folders:
        sys.exit("GLINT_DEVICE_PROGRAMS must name the folders of the built programs, with : between; ctest sets it")
    path = shutil.which(name, path=folders) or name
    if not os.path.exists(path):
        sys.exit(f"{path}: is not built")
    return path


def run(command, modules=(), copy=(), out=None, virtual_time=True, seconds=HOST_SECONDS):
    """Standard output of a command in the guest. Ends the test with 77 where there can be no guest, and with 1 when
    the command fails."""
    words = [sys.executable, os.path.join(HERE, "run_in_guest.py"), "--timeout", str(seconds)]
    words += ["--virtual-time"] if virtual_time else []
    for module in modules:
        words += ["--module", module]
    for path in copy:
        words += ["--copy", path]
    words += ["--out", out] if out else []
    done = subprocess.run([*words, "--", *command], stdout=subprocess.PIPE, text=True, check=False)
    if done.returncode == SKIPPED:
        print(done.stdout, end="")
        sys.exit(SKIPPED)
    if done.returncode != 0:
        print(done.stdout, end="")
        sys.exit(f"FAILED: the guest's command ended with {done.returncode}")
    return done.stdout


def make_frames(path, ticks, quality=90, markers=20):
    """A file of JPEG frames of the simulated rig."""
    subprocess.run([program("sim_frames"), "--out", path, "--ticks", str(ticks), "--quality", str(quality),
                    "--markers", str(markers)], check=True)


def capture_uvc(box, pulses, faults=(), frames=None, capture_options=(), ticks=None, rate_hz=90):
    """Four virtual cameras and v4l2_capture until silence; returns (Captured, rows of what was sent)."""
    frames = frames or os.path.join(box, "frames.jpgs")
    if not os.path.exists(frames):
        make_frames(frames, ticks or min(pulses, 90))
    script = os.path.join(box, "faults.txt")
    with open(script, "w", encoding="utf-8") as file:
        file.writelines(f"{line}\n" for line in faults)
    capture = " ".join(["v4l2_capture", "--rate", str(rate_hz), "--csv", "/run/out/frames.csv", *capture_options,
                        "$CAMERA_1 $CAMERA_2 $CAMERA_3 $CAMERA_4"])
    run([program("uvc_cameras"), "--frames", os.path.basename(frames), "--rate", str(rate_hz), "--pulses", str(pulses),
         "--faults", "faults.txt", "--log", "/run/out/sent.csv", "--", "sh", "-c", capture],
        modules=CAMERA_MODULES, copy=[program("v4l2_capture"), frames, script], out=box)
    return Captured(os.path.join(box, "frames.csv")), read_csv(os.path.join(box, "sent.csv"))


def read_csv(path):
    with open(path, encoding="utf-8", newline="") as file:
        return [{key: value if key in ("event", "fault") else int(value) for key, value in row.items()}
                for row in csv.DictReader(file)]


class Captured:
    """What v4l2_capture wrote, by camera: frames in their order, and events in theirs."""

    def __init__(self, path):
        self.frames, self.events = {}, {}
        for row in read_csv(path):
            by_camera = self.frames if row["event"] == "frame" else self.events
            by_camera.setdefault(row["camera"], []).append(row)

    def pulses(self, camera):
        return [row["pulse"] for row in self.frames.get(camera, [])]

    def steps_ms(self, camera):
        stamps = [row["stamp_us"] for row in self.frames[camera]]
        return sorted((b - a) / 1000 for a, b in zip(stamps, stamps[1:]))


class Verdict:
    """Collects what is wrong; finish() ends the test."""

    def __init__(self):
        self._wrong = []

    def expect(self, holds, text):
        if not holds:
            self._wrong.append(text)

    def finish(self):
        for text in self._wrong[:40]:
            print(f"FAILED: {text}")
        if not self._wrong:
            print("All as expected.")
        sys.exit(1 if self._wrong else 0)
