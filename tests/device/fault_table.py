# SPDX-License-Identifier: MIT
"""What faults of cameras did to a run of glint: read from its messages and from its sets, shown as a table."""
import json
import statistics

import guest_test

PROGRAMS = ["glint", "stamp_lines"]


def programs():
    return [guest_test.program(name) for name in PROGRAMS]


def track_command(devices, sets, out="/run/out"):
    """glint with its messages and sets kept for Run. Not in real time: the guest's one processor also plays the USB
    controller, in threads that would have to wait."""
    return (f"stamp_lines {out}/said.txt glint track v4l2:{devices} --rig rig.toml --device cpu --background /run/job "
            f"--realtime off --ticks {sets} --quiet --output jsonl:{out}/sets.jsonl --summary {out}/summary.json")


class Run:
    """A run of track_command()."""

    def __init__(self, folder):
        self.said = []  # (time_ns, text)
        with open(f"{folder}/said.txt", encoding="utf-8") as file:
            for line in file:
                time_ns, _, text = line.rstrip("\n").partition(" ")
                self.said.append((int(time_ns), text.removeprefix("glint: ")))
        self.sets = []  # dictionaries: tick, time_ns, stamped_ns, cameras
        with open(f"{folder}/sets.jsonl", encoding="utf-8") as file:
            self.sets = [json.loads(line) for line in file]
        with open(f"{folder}/summary.json", encoding="utf-8") as file:
            self.summary = json.load(file)

    def said_of(self, camera, after_ns, before_ns):
        """(time, text without the camera's name) of all that was said of it in between."""
        name = f"camera cam{camera} "
        return [(time_ns, text.removeprefix(name)) for time_ns, text in self.said
                if after_ns <= time_ns < before_ns and text.startswith(name)]

    def first_with(self, camera, after_ns, before_ns):
        """Time of the first set in between that has the camera's frame; None if there is none."""
        return next((one["time_ns"] for one in self.sets
                     if after_ns <= one["time_ns"] < before_ns and camera in one["cameras"]), None)

    def missing(self):
        """(set's index, camera) of every frame that is in no set, from the first set to the last. What a tick lacks of which
        there is no set stands with the next set."""
        for index, one in enumerate(self.sets):
            skipped = one["tick"] - self.sets[index - 1]["tick"] - 1 if index else 0
            for camera in range(1, 5):
                yield from [(index, camera)] * (skipped + (camera not in one["cameras"]))


class Fault:
    """Begun, ended and over (the next one begins) in ns. `says` stands in what glint says first; None: it says nothing; "":
    it may say something."""

    def __init__(self, kind, cameras, begun_ns, ended_ns, over_ns, says):
        self.kind, self.cameras, self.says = kind, cameras, says
        self.begun_ns, self.ended_ns, self.over_ns = begun_ns, ended_ns, over_ns


class Row:
    """A kind of fault, as often as it was."""

    def __init__(self):
        self.count, self.told, self.said, self.lost_of_others = 0, 0, "", 0
        self.noticed_ms, self.again_ms, self.lost = [], [], []

    def line(self, kind):
        said = f"{'' if self.told == self.count else f'{self.told} times '}`{self.said}`" if self.told else "nothing"
        lost = f"{statistics.median(self.lost):.0f} / {max(self.lost)}"
        return (f"| {kind} | {self.count} | {said} | {middle_and_most(self.noticed_ms)} | {lost} | {self.lost_of_others} | "
                f"{middle_and_most(self.again_ms)} |")


def middle_and_most(values_ms):
    return f"{statistics.median(values_ms):.0f} / {max(values_ms):.0f} ms" if values_ms else "-"


class FaultTable:
    """Faults that follow one another without gaps: every frame that is in no set belongs to one of them."""

    def __init__(self, run, period_ns, verdict):
        self._run, self._period_ns, self._verdict = run, period_ns, verdict
        self._missing = list(run.missing())
        self.rows = {}

    def add(self, fault):
        row = self.rows.setdefault(fault.kind, Row())
        where = f"{fault.kind} of {fault.cameras} at {(fault.begun_ns - self._run.sets[0]['time_ns']) / 1e9:.2f} s"
        row.count += 1
        self._add_said(fault, row, where)
        # The frame before the fault may not have left the camera.
        lost = [camera for index, camera in self._missing
                if fault.begun_ns - self._period_ns <= self._run.sets[index]["time_ns"] < fault.over_ns - self._period_ns]
        others = sum(1 for camera in lost if camera not in fault.cameras)
        self._verdict.expect(others == 0, f"{where}: {others} frames of others are in no set")
        row.lost_of_others += others
        row.lost.append(len(lost) - others)

    def _add_said(self, fault, row, where):
        said = [self._run.said_of(camera, fault.begun_ns, fault.over_ns) for camera in fault.cameras]
        if fault.says is None:
            self._verdict.expect(not any(said), f"{where}: is told: {said}")
        if not fault.says and not any(said):
            return
        for camera, texts in zip(fault.cameras, said):
            told = bool(texts) and fault.says in texts[0][1] and "is back" in texts[-1][1]
            self._verdict.expect(told, f"{where}: of camera {camera} only {texts} is said")
        again_ns = [self._again_ns(camera, fault) for camera in fault.cameras]
        self._verdict.expect(None not in again_ns, f"{where}: not in a set again")
        if all(said) and None not in again_ns:
            row.told += 1
            row.said = said[0][0][1].split(";")[0]
            row.noticed_ms.append((max(texts[0][0] for texts in said) - fault.begun_ns) / 1e6)
            row.again_ms.append((max(again_ns) - fault.ended_ns) / 1e6)

    def _again_ns(self, camera, fault):
        """When the camera is in a set for the first time after it was in none."""
        missing_ns = [self._run.sets[index]["time_ns"] for index, lost in self._missing if lost == camera]
        first_ns = next((time_ns for time_ns in missing_ns if fault.begun_ns <= time_ns < fault.over_ns), fault.ended_ns)
        return self._run.first_with(camera, max(fault.ended_ns, first_ns), fault.over_ns)

    def quiet_before(self, begun_ns):
        """No frame is missing before the first fault."""
        early = [one for one in self._missing if self._run.sets[one[0]]["time_ns"] < begun_ns - self._period_ns]
        self._verdict.expect(not early, f"{len(early)} frames are in no set before the first fault")

    def show(self):
        print("| fault | N | what glint says of the camera | after | its frames in no set | others' | in a set again after |")
        print("|---|---|---|---|---|---|---|")
        for kind, row in self.rows.items():
            print(row.line(kind))
        print("(median / most)")
