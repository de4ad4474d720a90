#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The sync board's pins are the same for the firmware, in the list for people, in the picture, and on the user's page."""
import os
import re
import sys
import unittest

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
sys.path.insert(0, os.path.join(ROOT, "hardware", "sync-carrier"))
import draw_wiring  # noqa: E402


def read(path):
    with open(os.path.join(ROOT, path), encoding="utf-8") as file:
        return file.read()


def firmware_pins():
    """{"kPinStrobe0 + 1": 7, ...}: the first of a row of pins stands for all of its kind."""
    wire = read("firmware/protocol/sync_report.h")
    count = {name: int(value) for name, value in re.findall(r"#define (GLINT_SYNC_\w+) +(\d+)\b", wire)}
    rows = {"kPinTrigger0": count["GLINT_SYNC_TRIGGERS"],
            "kPinStrobe0": count["GLINT_SYNC_OUTPUTS"] - count["GLINT_SYNC_TRIGGERS"]}
    pins = {}
    for name, number in re.findall(r"\bconstexpr unsigned (kPin\w+) = (\d+);", read("firmware/rp2040/pins.hpp")):
        for i in range(rows.pop(name, 1)):
            pins[f"{name} + {i}" if i else name] = int(number) + i
    assert not rows, f"pins.hpp has no {rows}"
    return pins


class PinoutTest(unittest.TestCase):
    def setUp(self):
        self.rows = draw_wiring.read_pinout()

    def test_every_pin_of_the_firmware_is_listed_with_its_number_and_no_other(self):
        listed = [(row["firmware"], row["gpio"]) for row in self.rows if row["firmware"] or row["gpio"] is not None]
        self.assertEqual(sorted(listed), sorted(firmware_pins().items()))

    def test_numbers_of_pins_and_names_are_those_of_the_pico(self):
        on_header = [row for row in self.rows if row["pico_pin"] is not None]
        numbers = [row["pico_pin"] for row in on_header]
        self.assertEqual(len(set(numbers)), len(numbers))
        for row in on_header:
            printed = draw_wiring.HEADER[row["pico_pin"] - 1]
            if row["gpio"] is not None:
                self.assertEqual(printed, f"GP{row['gpio']}")
            else:
                self.assertIn(printed, {"GND": ["GND"], "AGND": ["AGND"], "3.3 V": ["3V3"], "5 V": ["VBUS"]}[row["name"]])
        for row in self.rows:
            if row["pico_pin"] is None:
                self.assertNotIn(f"GP{row['gpio']}", draw_wiring.HEADER)

    def test_outputs_are_counted_from_0_in_the_order_of_the_firmware(self):
        outputs = {}
        for row in self.rows:
            found = re.fullmatch(r"output (\d) \((trigger|strobe)\)", row["name"])
            if found:
                outputs[int(found[1])] = (row["firmware"].partition(" ")[0], row["gpio"])
        pins = firmware_pins()
        expected = [(first, pins[first] + i) for first in ("kPinTrigger0", "kPinStrobe0") for i in range(4)]
        self.assertEqual([outputs.get(i) for i in range(8)], expected)

    def test_the_supply_is_measured_where_the_adc_listens(self):
        channel = int(re.search(r"kAdcSupply = (\d+);", read("firmware/rp2040/pins.hpp"))[1])
        self.assertEqual(firmware_pins()["kPinSupply"], 26 + channel)

    def test_the_divider_is_the_one_that_the_firmware_reckons_with(self):
        def kilo_ohms(firmware_or_name, key):
            (row,) = [row for row in self.rows if row[key] == firmware_or_name]
            return float(re.match(r"(\d+) kOhm", row["parts"])[1])

        upper, lower = kilo_ohms("kPinSupply", "firmware"), kilo_ohms("AGND", "name")
        scale = re.search(r"kSupplyFullScale_mv = 3300 \* (\d+);", read("firmware/rp2040/pins.hpp"))
        self.assertEqual((upper + lower) / lower, float(scale[1]))

    def test_the_picture_is_the_one_that_is_drawn_now(self):
        self.assertEqual(read("docs/sync-board-wiring.svg"), draw_wiring.make_svg(self.rows),
                         "run hardware/sync-carrier/draw_wiring.py")

    def test_the_users_page_has_the_same_pins(self):
        table = dict(re.findall(r"^\| (\d+) \| GP(\d+) \|", read("docs/sync-board.md"), re.MULTILINE))
        expected = {str(row["pico_pin"]): str(row["gpio"]) for row in self.rows
                    if row["gpio"] is not None and row["pico_pin"] is not None}
        self.assertEqual(table, expected)


if __name__ == "__main__":
    unittest.main()
