#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""`glint sync` with the firmware that users flash, on a real kernel: 10,000 reports at 90 and at 500 Hz through both back
ends of hidapi, a refusal, a cable pulled, a processor that dies, a reset, and a blank board that is flashed.
GLINT_FIRMWARE names the firmware."""
import json
import os
import shutil
import socket
import subprocess
import sys
import tempfile
import threading
import time

from board_server import BoardServer

HERE = os.path.dirname(os.path.abspath(__file__))
DEVICE_TESTS = os.path.join(os.path.dirname(HERE), "device")
sys.path.insert(0, DEVICE_TESTS)
import guest_test  # noqa: E402  (its folder is known only now)

FRAMES = int(os.environ.get("GLINT_BOARD_FRAMES", "10000"))
LIBUSB = "LD_PRELOAD=libhidapi-libusb.so.0"
RUNS = """
glint sync status --json > $OUT/status.json
glint sync start --rate 250 --exposure 137us > $OUT/refused.txt 2>&1; echo $? > $OUT/refused.code
glint sync start --rate 90 --exposure 137us --strobe-delay 788us --json > $OUT/start.json
glint sync watch --seconds {seconds_90} --json > $OUT/hidraw-90.jsonl
{libusb} glint sync watch --seconds {seconds_90} --json > $OUT/libusb-90.jsonl
glint sync start --rate 500 --exposure 40us --strobe-delay 788us --json > $OUT/faster.json
glint sync watch --seconds {seconds_500} --json > $OUT/hidraw-500.jsonl
{libusb} glint sync watch --seconds {seconds_500} --json > $OUT/libusb-500.jsonl
glint sync stop > $OUT/stop.txt
sleep 4
glint sync start --rate 90 --exposure 137us --strobe-delay 788us > $OUT/start.txt
glint sync watch --seconds 30 --json > $OUT/trouble.jsonl
"""
FLASH = """
glint sync status > $OUT/blank.txt 2>&1; echo $? > $OUT/blank.code
glint sync flash glint-sync.uf2 --yes > $OUT/flash.txt 2> $OUT/flash.log
glint sync status --json > $OUT/flashed.json
"""


def in_guest(box, boards, script, *files):
    path = os.path.join(box, "script.sh")
    with open(path, "w", encoding="utf-8") as file:
        file.write("OUT=/run/out\n" + script)
    words = [sys.executable, os.path.join(DEVICE_TESTS, "run_in_guest.py"), "--network", "--timeout", "900", "--out", box]
    for module in ("vhci-hcd", "usbhid", "hid-generic"):
        words += ["--module", module]
    for name in (guest_test.program("glint"), path, *files):
        words += ["--copy", name]
    words += ["--", guest_test.program("usbip_attach"), "--port", str(boards.port), "--", "sh", "script.sh"]
    code = subprocess.run(words, check=False).returncode
    if code != 0:
        sys.exit(code if code == guest_test.SKIPPED else 1)


def text(box, name):
    with open(os.path.join(box, name), encoding="utf-8") as file:
        return file.read()


def lines(box, name, kind):
    return [line for line in map(json.loads, text(box, name).splitlines()) if line["type"] == kind]


def make_trouble(boards):
    """Once the board starts again after a pause. Each with time to recover: a cable pulled, a processor that dies, the
    RUN pin."""
    with socket.create_connection(("127.0.0.1", boards.control_port)) as stream:
        stream.sendall(b"stream 2\n")
        last, count = time.monotonic(), 0
        for _ in stream.makefile("r"):
            now = time.monotonic()
            count += 1
            if count > FRAMES and now - last > 3:
                break
            last = now
    for wait_s, order in ((5, "unplug"), (3, "plug"), (6, "stop-processor"), (7, "reset")):
        time.sleep(wait_s)
        boards.ask(order)


def check_watched(verdict, box, name, rate_hz):
    summary, = lines(box, name, "summary")
    print(f"{name}: {summary['frames']} frames, {summary['missing']} missing, reports {summary['reports']}, "
          f"delay p99 {summary['report_delay']['p99_s'] * 1e3:.1f} ms")
    verdict.expect(summary["frames"] >= FRAMES, f"{name}: {summary['frames']} frames")
    verdict.expect(summary["missing"] == summary["reports"]["lost"] == summary["reports"]["flawed"] == 0, f"{name}: {summary}")
    rates = [line["rate_hz"] for line in lines(box, name, "update")[1:] if line["rate_hz"]]
    # An update a second, the first of which is left out.
    verdict.expect(len(rates) >= max(1, FRAMES // rate_hz - 2), f"{name}: {len(rates)} rates")
    verdict.expect(all(abs(rate / rate_hz - 1) < 1e-6 for rate in rates), f"{name}: rates {rates[:5]}")


def check_runs(verdict, box, boards):
    status = json.loads(text(box, "status.json"))
    print(f"status: {status['info']}")
    verdict.expect(text(box, "refused.code").strip() == "1" and "2.5 %" in text(box, "refused.txt"),
                   f"a strobe too bright is refused with: {text(box, 'refused.txt')}")
    print(f"refused: {text(box, 'refused.txt').strip()}")
    for name, rate_hz in (("hidraw-90", 90), ("libusb-90", 90), ("hidraw-500", 500), ("libusb-500", 500)):
        check_watched(verdict, box, f"{name}.jsonl", rate_hz)
    events = lines(box, "trouble.jsonl", "event")
    kinds = [event["event"] for event in events]
    print("trouble: " + "; ".join(f"{event['since_start_s']:.1f} s {event['text']}" for event in events))
    verdict.expect(kinds.count("gone") == kinds.count("back") == 3, f"gone and back three times: {kinds}")
    after = lines(box, "trouble.jsonl", "update")[-1]
    verdict.expect(after["present"], "the board is not there at the end")
    at_end = boards.ask("status")
    causes = [reset["cause"] for reset in at_end["resets"]]
    verdict.expect(causes == ["power", "watchdog", "run pin"], f"resets: {causes}")
    verdict.expect(not at_end["complaints"], f"the board says {at_end}")


def main():
    firmware = os.environ.get("GLINT_FIRMWARE")
    if not firmware:
        print("SKIPPED: GLINT_FIRMWARE names no firmware (needs gcc-arm-none-eabi when configuring)")
        sys.exit(guest_test.SKIPPED)
    verdict = guest_test.Verdict()
    with tempfile.TemporaryDirectory() as box, BoardServer(firmware) as boards:
        trouble = threading.Thread(target=make_trouble, args=(boards,), daemon=True)
        trouble.start()
        in_guest(box, boards, RUNS.format(libusb=LIBUSB, seconds_90=FRAMES / 90 + 2, seconds_500=FRAMES / 500 + 2))
        trouble.join(timeout=60)
        check_runs(verdict, box, boards)
    with tempfile.TemporaryDirectory() as box, BoardServer() as boards:
        file = os.path.join(box, "glint-sync.uf2")
        shutil.copy(firmware, file)
        in_guest(box, boards, FLASH, file)
        print(f"blank: {text(box, 'blank.txt').strip()}\nflash: {text(box, 'flash.txt').strip()}")
        verdict.expect(text(box, "blank.code").strip() == "1", "a blank board is no board")
        verdict.expect(json.loads(text(box, "flashed.json"))["status"]["epoch"] != 0, "the flashed board does not answer")
    verdict.finish()


if __name__ == "__main__":
    main()
