#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Each fault of a virtual UVC camera's frames shows what it shows through the real uvcvideo, 20 times each; the frames
around it are as they should be."""
import tempfile

import guest_test

# What the host gets of the pulse: frames that show it, sequence numbers missing before the next frame, whether the
# JPEG has its end, how late at least. No fault sets V4L2_BUF_FLAG_ERROR: the driver drops such frames.
EXPECTED = {
    "": {"frames": 1, "gap": 0, "whole": True},
    "never": {"frames": 0, "gap": 0},
    "twice": {"frames": 2, "gap": 0, "whole": True},
    "stale": {"frames": 0, "gap": 0},  # the pulse before it comes twice
    "error-bit": {"frames": 0, "gap": 1},
    "broken-packet": {"frames": 0, "gap": 1},
    "toggle": {"frames": 0, "gap": 0},
    "truncated": {"frames": 1, "gap": 0, "whole": False},
    "corrupt": {"frames": 1, "gap": 0, "whole": True},
    "late": {"frames": 1, "gap": 0, "whole": True},
}
LATE_MS, EACH_PER_CAMERA, SPACING, FIRST = 6, 5, 4, 10


def schedule():
    """(pulse, camera, kind): the cameras' faults differ at each pulse."""
    kinds = [kind for kind in EXPECTED if kind]
    for camera in range(1, 5):
        for turn in range(EACH_PER_CAMERA * len(kinds)):
            yield FIRST + SPACING * turn + camera - 1, camera, kinds[(turn + 2 * camera) % len(kinds)]


def check_camera(camera, faults, captured, sent, verdict):
    """Every pulse of one camera against the table."""
    frames = captured.frames[camera]
    time_us = {row["pulse"]: row["time_ns"] // 1000 for row in sent if row["camera"] == camera}
    expected_pulses = []
    for pulse in range(PULSES):
        kind = faults.get((pulse, camera), "")
        shown = pulse - 1 if kind == "stale" else pulse
        expected_pulses += [shown] * (1 if kind == "stale" else EXPECTED[kind]["frames"])
    verdict.expect(captured.pulses(camera) == expected_pulses, f"camera {camera}: other frames than expected")
    by_pulse = {row["pulse"]: row for row in frames}
    sequence_after = {}
    for before, after in zip(frames, frames[1:]):
        for pulse in range(before["pulse"] + 1, after["pulse"]):
            sequence_after[pulse] = after["sequence"] - before["sequence"] - 1
    usual_us = sorted(by_pulse[p]["stamp_us"] - time_us[p] for p in by_pulse)[len(by_pulse) // 2]
    for pulse in range(PULSES):
        kind = faults.get((pulse, camera), "")
        want = EXPECTED[kind]
        where = f"camera {camera} pulse {pulse} {kind or 'without fault'}"
        if want["frames"] == 0:
            gap = sequence_after.get(pulse, 0)
            verdict.expect(gap == want["gap"], f"{where}: sequence gap {gap}, expected {want['gap']}")
        elif pulse in by_pulse:
            row = by_pulse[pulse]
            verdict.expect(bool(row["whole"]) == want["whole"], f"{where}: whole {row['whole']}")
            late_us = row["stamp_us"] - time_us[pulse] - usual_us
            if kind == "late":
                verdict.expect(late_us >= (LATE_MS - 4) * 1000, f"{where}: only {late_us} us late")
        verdict.expect(not by_pulse.get(pulse, {"error": 0})["error"], f"{where}: flagged")


def spoilt_of(kind, faults, captured):
    """How many frames with that fault libjpeg-turbo found fault with."""
    return sum(row["spoilt"] for camera, rows in captured.frames.items() for row in rows
               if faults.get((row["pulse"], camera), "") == kind)


PULSES = FIRST + SPACING * EACH_PER_CAMERA * (len(EXPECTED) - 1) + 10


def main():
    faults = {(pulse, camera): kind for pulse, camera, kind in schedule()}
    lines = [f"{pulse} {camera} {kind}{f':{LATE_MS}' if kind == 'late' else ''}"
             for (pulse, camera), kind in faults.items()]
    verdict = guest_test.Verdict()
    with tempfile.TemporaryDirectory() as box:
        captured, sent = guest_test.capture_uvc(box, PULSES, lines, capture_options=["--decode"])
    for camera in range(1, 5):
        check_camera(camera, faults, captured, sent, verdict)
        gaps = captured.frames[camera][-1]["sequence"] + 1 - len(captured.frames[camera])
        verdict.expect(gaps == 2 * EACH_PER_CAMERA, f"camera {camera}: {gaps} sequence gaps in all")
    for kind in EXPECTED:
        count = sum(1 for k in faults.values() if k == kind) if kind else 4 * PULSES - len(faults)
        print(f"{kind or 'no fault':13} {count:4} times, {spoilt_of(kind, faults, captured)} frames that the decoder complains of")
    verdict.expect(spoilt_of("truncated", faults, captured) == 4 * EACH_PER_CAMERA, "truncated JPEGs decode without complaint")
    verdict.expect(spoilt_of("", faults, captured) == 0, "frames without fault are spoilt")
    verdict.finish()


if __name__ == "__main__":
    main()
