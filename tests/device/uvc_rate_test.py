#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Four virtual UVC cameras at 90 Hz, real uvcvideo: every pulse arrives from every camera, once and whole."""
import tempfile

import guest_test

PULSES, RATE_HZ = 360, 90
verdict = guest_test.Verdict()
with tempfile.TemporaryDirectory() as box:
    captured, sent = guest_test.capture_uvc(box, PULSES)
verdict.expect(len(sent) == 4 * PULSES, f"{len(sent)} exposures in the log")
for camera in range(1, 5):
    frames, steps_ms = captured.frames[camera], captured.steps_ms(camera)
    sequences = [row["sequence"] for row in frames]
    bad = sum(row["error"] or not row["whole"] for row in frames)
    lost = PULSES - len(set(captured.pulses(camera)))
    gaps = sequences[-1] - sequences[0] + 1 - len(sequences)
    print(f"camera {camera}: {len(frames)} frames, {lost} lost, {gaps} sequence gaps, {bad} bad, "
          f"step {steps_ms[len(steps_ms) // 2]:.2f} ms, longest {steps_ms[-1]:.2f} ms")
    verdict.expect(captured.pulses(camera) == list(range(PULSES)), f"camera {camera}: frames lost or out of order")
    verdict.expect(gaps == 0, f"camera {camera}: {gaps} sequence gaps")
    verdict.expect(bad == 0, f"camera {camera}: {bad} bad frames")
    verdict.expect(camera not in captured.events, f"camera {camera}: {captured.events.get(camera)}")
    # Stamps fall on the ends of transfers, 4 ms apart.
    verdict.expect(steps_ms[-1] <= 1000 / RATE_HZ + 4.1, f"camera {camera}: a step of {steps_ms[-1]} ms")
verdict.finish()
