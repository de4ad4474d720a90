#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""`glint track v4l2:` while cameras lose, repeat, delay and cut frames: its ledger is what was injected, and no point is
made of frames that do not belong together."""
import math
import tempfile

import glint_live_test
import guest_test

# Counts that a fault adds to. A frame that is more than half a period late could be the next pulse's: it is not placed.
COUNTS_OF = {
    "never": ["lost_by_camera"],
    "toggle": ["lost_by_camera"],
    "error-bit": ["lost_by_host"],
    "twice": ["duplicates"],
    "truncated": ["corrupt"],
    "late:30": [],
    "late:120": ["lost_by_camera", "unplaced"],
}
EACH_PER_CAMERA, SPACING = 2, 2
FIRST = 30  # the first 24 or so frames of each camera only teach its clock
LAST = FIRST + SPACING * 4 * EACH_PER_CAMERA * len(COUNTS_OF)
SETS, TICKS = LAST - 20, LAST + 10
# Three cameras see less than four, and a point of two is worse still: it may move by what noise allows.
MOST_APART_M = 2e-3


def injected():
    """(pulse, camera, fault), no two at once."""
    kinds = list(COUNTS_OF)
    for number, pulse in enumerate(range(FIRST, LAST, SPACING)):
        yield pulse, 1 + number % 4, kinds[number // 4 % len(kinds)]


def check_ledger(ledger, faults, sets, verdict, counts_of=None):
    counts_of = counts_of or COUNTS_OF
    for camera, entries in enumerate(ledger["cameras"], 1):
        added = [count for _, who, fault in faults if who == camera for count in counts_of[fault]]
        print(f"camera {camera}: " + ", ".join(f"{count} {name}" for name, count in entries.items() if name != "name" and count))
        for name, count in entries.items():
            if name not in ("name", "used"):
                verdict.expect(count == added.count(name), f"camera {camera}: {count} {name}, injected {added.count(name)}")
        lost = sum(entries[name] for name in ("late", "skipped", "lost_by_host", "lost_by_camera", "corrupt", "dark"))
        verdict.expect(entries["used"] + lost == ledger["pulses"] == sets,
                       f"camera {camera}: {entries['used']} + {lost} entries for {ledger['pulses']} pulses of {sets}")


def main():
    verdict = guest_test.Verdict()
    faults = list(injected())
    with tempfile.TemporaryDirectory() as box:
        from_files = glint_live_test.track_files(box, glint_live_test.prepare(box, TICKS))
        live, summary = glint_live_test.track_live(box, SETS, [f"{pulse} {camera} {fault}" for pulse, camera, fault in faults])
    check_ledger(summary["ledger"], faults, SETS, verdict)
    verdict.expect(min(live) < FIRST and max(live) >= LAST, f"faults at {FIRST} to {LAST}, points at {min(live)} to {max(live)}")
    worst = 0.0
    for pulse, points in live.items():
        for point in points:
            apart = min((math.dist(point, other) for other in from_files.get(pulse, [])), default=math.inf)
            worst = max(worst, apart)
            verdict.expect(apart <= MOST_APART_M, f"pulse {pulse}: a point {apart} m from the nearest of the file run")
    print(f"{len(faults)} faults; worst point {worst * 1e6:.0f} um from that of the file run")
    verdict.finish()


if __name__ == "__main__":
    main()
