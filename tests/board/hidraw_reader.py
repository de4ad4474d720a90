#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What kernel_test.py runs in the guest: speaks to the board through /dev/hidraw*, without any library of ours."""
import fcntl
import glob
import json
import os
import sys
import time

REPORT_BYTES = 56  # firmware/protocol/sync_report.h
STATUS, RUN, COMMAND, OUTPUT = 0x10, 0x11, 0x14, 0x20
STOP, START, RESET, RESET_MAGIC = 0, 1, 6, 0x7E57B0A2
REPORTS = 300


def feature_request(number, size):
    return 3 << 30 | size << 16 | ord("H") << 8 | number


def open_board(seconds=30.0):
    latest = time.monotonic() + seconds
    while time.monotonic() < latest:
        for path in glob.glob("/sys/class/hidraw/*"):
            try:
                return open("/dev/" + os.path.basename(path), "r+b", buffering=0)
            except OSError:
                pass
        time.sleep(0.05)
    sys.exit("no /dev/hidraw node")


def get(board, report):
    answer = bytearray(64)
    answer[0] = report
    return bytes(answer[:fcntl.ioctl(board, feature_request(0x07, len(answer)), answer)])


def put(board, report, fields):
    data = bytearray((bytes([report, 1]) + fields).ljust(REPORT_BYTES, b"\0"))
    fcntl.ioctl(board, feature_request(0x06, len(data)), data)


def word(value):
    return value.to_bytes(4, "little")


def number_of(report):
    return int.from_bytes(report[8:12], "little")


def epoch_of(report):
    return int.from_bytes(report[4:8], "little")


def main():
    board = open_board()
    for output in range(8):
        strobe = output > 3
        delay_ticks, width_ticks = (98500, 30000) if strobe else (0, 125000)
        put(board, OUTPUT + output, bytes([1, 1, 0, 0, 0, 0]) + word(delay_ticks) + word(width_ticks))
    put(board, RUN, bytes([0, 0]) + word(125_000_000 // 90))
    try:
        put(board, 0x99, b"")
        refused = None
    except OSError as error:
        refused = error.strerror
    put(board, COMMAND, bytes([START, 0]))
    numbers = [number_of(os.read(board.fileno(), 64)) for _ in range(REPORTS)]
    put(board, COMMAND, bytes([STOP, 0]))
    epoch = epoch_of(get(board, STATUS))
    put(board, COMMAND, bytes([RESET, 0]) + word(RESET_MAGIC))
    try:
        while True:
            os.read(board.fileno(), 64)
    except OSError as error:
        gone = error.strerror
    board.close()
    time.sleep(0.5)
    again = open_board()
    result = {"refused": refused, "gone": gone, "gaps": sum(b != a + 1 for a, b in zip(numbers, numbers[1:])),
              "reports": len(numbers), "new_epoch": epoch_of(get(again, STATUS)) != epoch}
    print(json.dumps(result))


main()
