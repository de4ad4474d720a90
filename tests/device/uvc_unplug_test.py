#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""A camera that hangs is silent and comes back; one whose cable is pulled fails with ENODEV at once and can be opened
again when it is back. The other cameras lose nothing."""
import tempfile

import guest_test

PULSES, RATE_HZ = 400, 90
HANG, RESUME, UNPLUG, REPLUG = 60, 100, 180, 200
FAULTS = [f"{HANG} 2 hang", f"{RESUME} 2 resume", f"{UNPLUG} 3 unplug", f"{REPLUG} 3 replug"]

verdict = guest_test.Verdict()
with tempfile.TemporaryDirectory() as box:
    captured, sent = guest_test.capture_uvc(box, PULSES, FAULTS, capture_options=["--reopen"])
for camera in (1, 4):
    verdict.expect(captured.pulses(camera) == list(range(PULSES)), f"camera {camera}: not touched, but it lost frames")
    verdict.expect(camera not in captured.events, f"camera {camera}: {captured.events.get(camera)}")

times_us = [row["time_us"] for row in captured.frames[2]]
silence_ms = max(b - a for a, b in zip(times_us, times_us[1:])) / 1000
print(f"hang: silent for {silence_ms:.1f} ms")
verdict.expect(silence_ms >= (RESUME - HANG) * 1000 / RATE_HZ - 12, f"camera 2 hung, but was silent for {silence_ms} ms")
verdict.expect(captured.pulses(2)[-1] == PULSES - 1, f"camera 2 does not come back: {captured.pulses(2)[-5:]}")
verdict.expect(2 not in captured.events, f"camera 2: {captured.events.get(2)}")

events = captured.events.get(3, [])
names = [row["event"] for row in events]
verdict.expect(names == ["ENODEV", "reopened"], f"camera 3: unplugged and back, but events are {names}")
if names == ["ENODEV", "reopened"]:
    pulled_us = next(r["time_ns"] for r in sent if r["pulse"] == UNPLUG and r["camera"] == 3) / 1000
    back_us = next(r["time_ns"] for r in sent if r["pulse"] == REPLUG and r["camera"] == 3) / 1000
    seen_ms, back_ms = (events[0]["time_us"] - pulled_us) / 1000, (events[1]["time_us"] - back_us) / 1000
    print(f"unplug: ENODEV after {seen_ms:.1f} ms; open again {back_ms:.1f} ms after the cable is back")
    verdict.expect(seen_ms < 20, f"camera 3: ENODEV only after {seen_ms} ms")
    missing = sorted(set(range(PULSES)) - set(captured.pulses(3)))
    verdict.expect(missing == list(range(missing[0], missing[-1] + 1)), f"camera 3: lost {missing}, not in one piece")
    verdict.expect(UNPLUG - 1 <= missing[0] <= UNPLUG, f"camera 3: lost from {missing[0]}")
verdict.finish()
