#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Four v4l2loopback devices carry 1280x800 grey at 250 Hz without losing a frame."""
import os
import tempfile

import guest_test

FRAMES, RATE_HZ = 2000, 250
verdict = guest_test.Verdict()
with tempfile.TemporaryDirectory() as box:
    guest_test.run(
        [guest_test.program("loopback_feeder"), "--rate", str(RATE_HZ), "--device", *guest_test.LOOPBACK_NODES, "--",
         "v4l2_capture", "--format", "GREY", "--frames", str(FRAMES), "--csv", "/run/out/frames.csv",
         *guest_test.LOOPBACK_NODES],
        modules=[guest_test.LOOPBACK_MODULE], copy=[guest_test.program("v4l2_capture")], out=box)
    captured = guest_test.Captured(os.path.join(box, "frames.csv"))
for camera in range(1, 5):
    pulses, steps_ms = captured.pulses(camera), captured.steps_ms(camera)
    missing = pulses[-1] - pulses[0] + 1 - len(set(pulses))
    print(f"camera {camera}: {len(pulses)} frames, {missing} lost, step {steps_ms[len(steps_ms) // 2]:.2f} ms, "
          f"longest {steps_ms[-1]:.2f} ms")
    verdict.expect(len(pulses) >= FRAMES, f"camera {camera}: {len(pulses)} frames of {FRAMES}")
    verdict.expect(pulses == list(range(pulses[0], pulses[0] + len(pulses))), f"camera {camera}: {missing} frames lost")
    verdict.expect(abs(steps_ms[len(steps_ms) // 2] - 1000 / RATE_HZ) < 0.1 and steps_ms[-1] < 2000 / RATE_HZ,
                   f"camera {camera}: not at {RATE_HZ} Hz: longest step {steps_ms[-1]} ms")
verdict.finish()
