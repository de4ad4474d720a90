#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Draws the sync board's wiring as it stands in pinout.csv: a Pico seen from above, and what hangs on its pins.

    draw_wiring.py            writes docs/sync-board-wiring.svg
    draw_wiring.py --check    exit code 1 if that file is not what would be written
"""
import csv
import os
import sys
from xml.sax.saxutils import escape

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
PINOUT = os.path.join(HERE, "pinout.csv")
PICTURE = os.path.join(ROOT, "docs", "sync-board-wiring.svg")

# What the Pico's data sheet prints beside its pins, 1 to 40.
HEADER = ("GP0 GP1 GND GP2 GP3 GP4 GP5 GND GP6 GP7 GP8 GP9 GND GP10 GP11 GP12 GP13 GND GP14 GP15 "
          "GP16 GP17 GND GP18 GP19 GP20 GP21 GND GP22 RUN GP26 GP27 AGND GP28 ADC_VREF 3V3 3V3_EN GND VSYS VBUS").split()
SIDE = 20  # pins in a row

WIDTH, HEIGHT = 1420, 1060
TOP, PITCH = 170, 44
BOARD_LEFT, BOARD_RIGHT = 520, 800
BOX_WIDTH, BOX_HEIGHT = 300, 36
LEFT_BOX, RIGHT_BOX = 30, WIDTH - 30 - BOX_WIDTH

INK, FAINT, PAPER, PCB = "#222222", "#8a8a8a", "#ffffff", "#e9eeea"
COLOURS = {"trigger": "#2b5f8a", "strobe": "#9a5a12", "sync": "#3b6e45", "supply": "#8c3a3a", "ground": "#444444"}


def read_pinout():
    """The rows, as dictionaries; those without a pin on the header have pico_pin None."""
    with open(PINOUT, newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    for row in rows:
        for number in ("pico_pin", "gpio"):
            row[number] = int(row[number]) if row[number] else None
    return rows


def kind_of(row):
    if row["direction"] in ("ground", "power"):
        return "ground" if row["direction"] == "ground" else "supply"
    for word in ("trigger", "strobe", "sync", "supply"):
        if word in row["name"]:
            return "strobe" if row["name"] == "strobes low" else word
    return "ground"


def pin_y(pin):
    return TOP + PITCH * (pin - 1 if pin <= SIDE else 2 * SIDE - pin)


class Drawing:
    def __init__(self):
        self.parts = []

    def add(self, text):
        self.parts.append(text)

    def line(self, points, colour, width=1.8):
        path = " ".join(f"{x:g},{y:g}" for x, y in points)
        self.add(f'<polyline points="{path}" fill="none" stroke="{colour}" stroke-width="{width:g}"/>')

    def rect(self, x, y, width, height, stroke, fill=PAPER, radius=0.0, line=1.5):
        self.add(f'<rect x="{x:g}" y="{y:g}" width="{width:g}" height="{height:g}" rx="{radius:g}" fill="{fill}" '
                 f'stroke="{stroke}" stroke-width="{line:g}"/>')

    def dot(self, x, y, colour, radius=3.5, fill=None):
        self.add(f'<circle cx="{x:g}" cy="{y:g}" r="{radius:g}" fill="{fill or colour}" stroke="{colour}"/>')

    def text(self, x, y, text, size=13, anchor="start", colour=INK, bold=False):
        weight = ' font-weight="bold"' if bold else ""
        self.add(f'<text x="{x:g}" y="{y:g}" font-size="{size:g}" text-anchor="{anchor}" fill="{colour}"{weight}>'
                 f"{escape(text)}</text>")

    def resistor(self, x, y, value, colour, upright=False):
        """Its middle is (x, y)."""
        width, height = (20, 46) if upright else (58, 18)
        self.rect(x - width / 2, y - height / 2, width, height, colour)
        if upright:
            self.text(x + width / 2 + 5, y + 4.5, value, 12)
        else:
            self.text(x, y + 4.5, value, 12, "middle")

    def ground(self, x, y, colour):
        """Ground symbol at the right end of a wire."""
        for half, step in ((9, 0), (6, 4), (3, 8)):
            self.line([(x + step, y - half), (x + step, y + half)], colour)

    def capacitor(self, x, y, value, colour):
        self.rect(x - 15, y - 3.5, 30, 7, PAPER, line=0)
        for dy in (-4, 4):
            self.line([(x - 15, y + dy), (x + 15, y + dy)], colour, 2.4)
        self.text(x + 20, y + 4.5, value, 12)

    def diode_upward(self, x, y, colour):
        self.add(f'<path d="M{x - 11:g},{y + 9:g} L{x + 11:g},{y + 9:g} L{x:g},{y - 9:g} Z" fill="{PAPER}" '
                 f'stroke="{colour}" stroke-width="1.8"/>')
        self.line([(x - 11, y - 9), (x + 11, y - 9)], colour, 2.4)


def short(value):
    return value.replace(" kOhm", " kΩ").replace(" Ohm", " Ω")


def draw_pico(drawing, rows):
    used = {row["pico_pin"] for row in rows}
    drawing.rect(BOARD_LEFT, TOP - 62, BOARD_RIGHT - BOARD_LEFT, PITCH * (SIDE - 1) + 92, INK, PCB, 10)
    middle = (BOARD_LEFT + BOARD_RIGHT) / 2
    drawing.rect(middle - 34, TOP - 78, 68, 44, INK, "#d4d4d4", 3)
    drawing.text(middle, TOP - 52, "USB", 13, "middle")
    drawing.rect(middle - 42, TOP + 18, 38, 22, FAINT, PAPER, 4)
    drawing.text(middle - 23, TOP + 55, "BOOTSEL", 10, "middle", FAINT)
    drawing.rect(BOARD_LEFT + 40, TOP - 42, 16, 10, COLOURS["sync"], "#cfe3d2", 2)
    drawing.text(BOARD_LEFT + 62, TOP - 33, "LED", 10, colour=FAINT)
    drawing.rect(middle - 40, TOP + 8.2 * PITCH, 80, 80, FAINT, "#d4d4d4", 3)
    drawing.text(middle, TOP + 8.2 * PITCH + 45, "RP2040", 13, "middle")
    drawing.text(middle, TOP + 13 * PITCH, "Raspberry Pi", 14, "middle", bold=True)
    drawing.text(middle, TOP + 13 * PITCH + 18, "Pico", 14, "middle", bold=True)
    drawing.text(middle, TOP + 13 * PITCH + 38, "seen from above", 12, "middle", FAINT)
    for pin, name in enumerate(HEADER, 1):
        left, y = pin <= SIDE, pin_y(pin)
        x = BOARD_LEFT if left else BOARD_RIGHT
        inward = 1 if left else -1
        colour = INK if pin in used else FAINT
        drawing.dot(x, y, colour, 7, PAPER)
        drawing.text(x + 14 * inward, y + 4.5, str(pin), 12, "start" if left else "end", colour)
        drawing.text(x + 40 * inward, y + 4.5, name, 12, "start" if left else "end", colour, bold=pin in used)


def draw_box(drawing, x, y, row):
    colour = COLOURS[kind_of(row)]
    drawing.rect(x, y - BOX_HEIGHT / 2, BOX_WIDTH, BOX_HEIGHT, colour, radius=4)
    drawing.text(x + 9, y - 2.5, row["name"], 12, bold=True, colour=colour)
    drawing.text(x + 9, y + 12, row["goes_to"], 11)


def draw_left(drawing, row):
    """Wires of the left row; resistors stand where `parts` says so."""
    colour, y = COLOURS[kind_of(row)], pin_y(row["pico_pin"])
    box_end = LEFT_BOX + BOX_WIDTH
    drawing.line([(BOARD_LEFT - 7, y), (box_end, y)], colour)
    value, _, how = short(row["parts"]).partition(" in ")
    if how == "series":
        drawing.resistor((BOARD_LEFT + box_end) / 2, y, value, colour)
    draw_box(drawing, LEFT_BOX, y, row)


def draw_pulldowns(drawing, rows):
    """A resistor to ground beneath each wire of a strobe."""
    colour, grey = COLOURS["strobe"], COLOURS["ground"]
    for row in rows:
        value, _, where = row["parts"].partition(" to ")
        if kind_of(row) != "strobe" or where != "GND":
            continue
        x, y = LEFT_BOX + BOX_WIDTH + 36, pin_y(row["pico_pin"])
        beneath = y + PITCH / 2
        drawing.line([(x, y), (x, beneath), (x + 110, beneath)], colour)
        drawing.dot(x, y, colour)
        drawing.resistor(x + 55, beneath, short(value), colour)
        drawing.ground(x + 110, beneath, grey)


def draw_jumper(drawing, row):
    x, y = BOARD_LEFT - 60, pin_y(row["pico_pin"])
    colour = COLOURS["strobe"]
    drawing.line([(x, y), (x, y - 12)], colour)
    drawing.line([(x, y - PITCH), (x, y - PITCH + 12)], colour)
    drawing.rect(x - 8, y - PITCH + 8, 16, PITCH - 16, colour, radius=3)
    drawing.text(x + 12, y - PITCH / 2 + 4.5, "jumper", 11)


def draw_right(drawing, row):
    colour, y = COLOURS[kind_of(row)], pin_y(row["pico_pin"])
    drawing.line([(BOARD_RIGHT + 7, y), (RIGHT_BOX, y)], colour)
    draw_box(drawing, RIGHT_BOX, y, row)


def draw_divider(drawing, rows):
    """The lights' supply, an eighth of it at GP26, never above 3.3 V."""
    (supply,) = [row for row in rows if row["name"] == "supply of the lights"]
    by_name = {row["name"]: row for row in rows if row["parts"]}
    agnd, clamp = by_name["AGND"], by_name["3.3 V"]
    red, grey = COLOURS["supply"], COLOURS["ground"]
    y, y_agnd, y_clamp = (pin_y(row["pico_pin"]) for row in (supply, agnd, clamp))
    x_resistor, x_capacitor, x_diode = BOARD_RIGHT + 36, BOARD_RIGHT + 112, BOARD_RIGHT + 194
    low, _, rest = agnd["parts"].partition(" and ")
    drawing.line([(BOARD_RIGHT + 7, y), (RIGHT_BOX, y)], red)
    drawing.line([(BOARD_RIGHT + 7, y_agnd), (x_capacitor, y_agnd)], grey)
    drawing.line([(BOARD_RIGHT + 7, y_clamp), (x_diode, y_clamp), (x_diode, y)], red)
    drawing.line([(x_resistor, y_agnd), (x_resistor, y)], grey)
    drawing.line([(x_capacitor, y_agnd), (x_capacitor, y)], grey)
    middle = (y + y_agnd) / 2
    drawing.resistor(x_resistor, middle, short(low), grey, upright=True)
    drawing.capacitor(x_capacitor, middle, rest.partition(" to ")[0], grey)
    drawing.diode_upward(x_diode, (y + y_clamp) / 2, red)
    drawing.text(x_diode + 18, (y + y_clamp) / 2 + 4.5, "Schottky diode: not above 3.3 V", 12)
    drawing.resistor((x_diode + RIGHT_BOX) / 2, y, short(supply["parts"].removesuffix(" in series")), red)
    drawing.dot(x_resistor, y_agnd, grey)
    for x in (x_resistor, x_capacitor, x_diode):
        drawing.dot(x, y, red)
    draw_box(drawing, RIGHT_BOX, y, supply)


NOTES = ("Signals are of 3.3 V. Nothing above that may reach a pin.",
         "The Pico is powered through USB. It does not power the lights.",
         "A light driver needs a stronger supply, and a MOSFET or a",
         "constant-current stage; its ground is joined with the Pico's.",
         "Without lights: a wire from pin 31 to pin 33 instead of the divider.",
         "Strobes active low: put the jumper on, and let the four 10 kΩ",
         "go to 3.3 V (pin 36) instead of GND.",
         "For the self-test one wire goes from the output to pin 19.")


def draw_notes(drawing):
    x, y = BOARD_RIGHT + 110, pin_y(31) + 90
    drawing.rect(x, y, WIDTH - 30 - x, 34 + 22 * len(NOTES), FAINT, radius=4, line=1)
    for i, note in enumerate(NOTES):
        drawing.text(x + 16, y + 32 + 22 * i, note, 13)


def make_svg(rows):
    drawing = Drawing()
    drawing.add(f'<rect width="{WIDTH}" height="{HEIGHT}" fill="{PAPER}"/>')
    drawing.text(LEFT_BOX, 40, "glint sync board: wiring", 20, bold=True)
    drawing.text(LEFT_BOX, 62, "made by hardware/sync-carrier/draw_wiring.py from pinout.csv", 12, colour=FAINT)
    on_header = [row for row in rows if row["pico_pin"] is not None]
    for row in on_header:
        if row["pico_pin"] <= SIDE:
            draw_left(drawing, row)
        elif not row["parts"]:
            draw_right(drawing, row)
    draw_pulldowns(drawing, on_header)
    (jumper,) = [row for row in on_header if row["parts"].startswith("jumper")]
    draw_jumper(drawing, jumper)
    draw_divider(drawing, on_header)
    draw_pico(drawing, on_header)
    draw_notes(drawing)
    return (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" width="{WIDTH}" '
            f'height="{HEIGHT}" font-family="Helvetica, Arial, sans-serif">\n'
            "<title>Wiring of the glint sync board</title>\n" + "\n".join(drawing.parts) + "\n</svg>\n")


def main():
    if sys.argv[1:] not in ([], ["--check"]):
        sys.exit(__doc__)
    svg = make_svg(read_pinout())
    if not sys.argv[1:]:
        with open(PICTURE, "w", encoding="utf-8") as file:
            file.write(svg)
        return
    with open(PICTURE, encoding="utf-8") as file:
        if file.read() != svg:
            sys.exit("docs/sync-board-wiring.svg is not up to date: run hardware/sync-carrier/draw_wiring.py")


if __name__ == "__main__":
    main()
