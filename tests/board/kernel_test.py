#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The firmware that users flash, on the simulated board, as a HID device of a real kernel: reports without gaps, exact
pulses meanwhile, a refusal, a reset. GLINT_FIRMWARE names the firmware."""
import json
import os
import subprocess
import sys
from collections import Counter

from board_server import BoardServer

HERE = os.path.dirname(os.path.abspath(__file__))
DEVICE_TESTS = os.path.join(os.path.dirname(HERE), "device")
PERIOD_NS = 125_000_000 // 90 * 8
sys.path.insert(0, DEVICE_TESTS)
import guest_test  # noqa: E402  (its folder is known only now)

verdict = guest_test.Verdict()
firmware = os.environ.get("GLINT_FIRMWARE")
if not firmware:
    print("SKIPPED: GLINT_FIRMWARE names no firmware (needs gcc-arm-none-eabi when configuring)")
    sys.exit(guest_test.SKIPPED)
with BoardServer(firmware) as board:
    for pin in (2, 6):
        board.ask(f"watch {pin}")
    words = [sys.executable, os.path.join(DEVICE_TESTS, "run_in_guest.py"), "--network", "--timeout", "240"]
    for module in ("vhci-hcd", "usbhid", "hid-generic"):
        words += ["--module", module]
    words += ["--copy", os.path.join(HERE, "hidraw_reader.py"), "--", guest_test.program("usbip_attach"),
              "--port", str(board.port), "--", "python3", "hidraw_reader.py"]
    done = subprocess.run(words, stdout=subprocess.PIPE, text=True, check=False)
    print(done.stdout, end="")
    if done.returncode != 0:
        sys.exit(done.returncode if done.returncode == guest_test.SKIPPED else 1)
    edges = {pin: board.ask(f"edges {pin}")[1:] for pin in (2, 6)}
    status = board.ask("status")
seen = json.loads(done.stdout.splitlines()[-1])
verdict.expect(seen["refused"] == "Broken pipe", f"an unknown report is refused as {seen['refused']}")
verdict.expect(seen["reports"] == 300 and seen["gaps"] == 0, f"{seen['gaps']} gaps in {seen['reports']} reports")
verdict.expect(seen["gone"] is not None and seen["new_epoch"], f"the reset is seen as {seen}")
verdict.expect(len(status["resets"]) == 2 and not status["complaints"], f"the board says {status}")
for pin, width_ns in ((2, 1_000_000), (6, 240_000)):
    rises = [time for time, level in edges[pin] if level]
    falls = [time for time, level in edges[pin] if not level]
    periods = Counter(b - a for a, b in zip(rises, rises[1:]))
    widths = Counter(b - a for a, b in zip(rises, falls))
    verdict.expect(len(rises) >= 290 and set(periods) == {PERIOD_NS}, f"pin {pin}: periods {periods}")
    verdict.expect(set(widths) == {width_ns}, f"pin {pin}: widths {widths}")
verdict.finish()
