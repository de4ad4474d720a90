#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Makes README.md in this folder from the results of glint bench in VENDOR/DEVICE.json.

    make_readme.py [FOLDER]            writes FOLDER/README.md (FOLDER: where this script lies)
    make_readme.py --check [FOLDER]    exit code 1 if it is not up to date, or a result is not fit to be kept
"""
import json
import os
import sys

SCHEMA = {"name": "glint-bench", "version": 1}
LARGEST_BYTES = 200_000
HEAD = """# Reference results

Made by `make_readme.py` from the files in this folder; [docs/benchmark.md](../../docs/benchmark.md) says how to add one.
Median milliseconds per tick, from submit to result, one tick at a time. "Most cameras": of 1280x800 with 20 blobs each,
p99 under the frame time. Rows marked "software" ran without a GPU: no figure of theirs says anything about one.
"""


class BadResult(Exception):
    """The text names the file and what is wrong."""


def read_result(path, shown):
    size = os.path.getsize(path)
    if size > LARGEST_BYTES:
        raise BadResult(f"{shown}: {size} bytes, at most {LARGEST_BYTES} are kept: use glint bench -o json --no-samples")
    try:
        with open(path, encoding="utf-8") as file:
            result = json.load(file)
    except ValueError as error:
        raise BadResult(f"{shown}: is damaged or no JSON: {error}") from error
    if not isinstance(result, dict) or result.get("schema") != SCHEMA:
        raise BadResult(f"{shown}: is not a result of glint bench -o json (schema {SCHEMA['name']} {SCHEMA['version']})")
    return result


def result_files(folder):
    """(path, VENDOR/DEVICE.json), sorted."""
    found = []
    for vendor in sorted(os.listdir(folder)):
        if os.path.isdir(os.path.join(folder, vendor)):
            for name in sorted(os.listdir(os.path.join(folder, vendor))):
                if name.endswith(".json"):
                    found.append((os.path.join(folder, vendor, name), f"{vendor}/{name}"))
    return found


def scene_key(scene):
    return (scene["width_px"] * scene["height_px"], scene["width_px"], scene["cameras"], scene["noise_grey"],
            scene["blobs"])


def scene_text(key):
    _, width, cameras, noise, blobs = key
    height = key[0] // width
    return f"{cameras} x {width}x{height}, {blobs} blobs" + ("" if noise == 1.2 else f", noise {noise:g}")


def device_type(device):
    if device["vulkan"] is None:
        return "native, without Vulkan"
    return "**software, no GPU**" if device["software"] else device["vulkan"]["device_type"]


def order(entry):
    """GPUs first, then software, then the native detector; by name within."""
    device = entry[0]
    kind = 2 if device["vulkan"] is None else 1 if device["software"] else 0
    return (kind, device["name"].lower(), entry[2])


def headline_text(headline):
    if headline["outcome"] != "ok":
        return headline["outcome"]
    return f"{headline['cameras']}{' or more' if headline['at_limit'] else ''}"


def table(entries):
    scenes = sorted({scene_key(row["scene"]) for device, _, _ in entries for row in device["rows"]})
    rates = sorted({headline["rate_hz"] for device, _, _ in entries for headline in device["headlines"]})
    head = ["device", "type", "driver", "processor", "glint", *(scene_text(scene) for scene in scenes),
            *(f"most cameras at {rate:g} Hz" for rate in rates), "file"]
    lines = [head, ["---"] * len(head)]
    for device, result, shown in entries:
        medians = {scene_key(row["scene"]): f"{1e3 * row['wall']['p50_s']:.3f}" if row["outcome"] == "ok"
                   else row["outcome"] for row in device["rows"]}
        most = {headline["rate_hz"]: headline_text(headline) for headline in device["headlines"]}
        vulkan = device["vulkan"]
        lines.append([device["name"], device_type(device),
                      f"{vulkan['driver_name']} {vulkan['driver_info']}".strip() if vulkan else "",
                      f"{result['machine']['processor']}, {result['machine']['logical_cores']} cores",
                      f"{result['glint_version']} ({result['glint_commit']})",
                      *(medians.get(scene, "") for scene in scenes), *(most.get(rate, "") for rate in rates),
                      f"[{shown}]({shown})"])
    return "".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |\n" for line in lines)


def readme(folder):
    entries = []
    for path, shown in result_files(folder):
        result = read_result(path, shown)
        try:
            entries.extend((device, result, shown) for device in result["devices"])
            table(entries[-len(result["devices"]):])  # so that what is missing is missed in its own file
        except (KeyError, TypeError) as error:
            raise BadResult(f"{shown}: is not complete: {error!r}") from error
    entries.sort(key=order)
    return HEAD + "\n" + (table(entries) if entries else "There are none yet.\n")


def main(arguments):
    check = "--check" in arguments
    folders = [a for a in arguments if a != "--check"] or [os.path.dirname(os.path.abspath(__file__))]
    target = os.path.join(folders[0], "README.md")
    try:
        text = readme(folders[0])
    except BadResult as error:
        print(error)
        return 1
    if not check:
        with open(target, "w", encoding="utf-8") as file:
            file.write(text)
        return 0
    there = ""
    if os.path.exists(target):
        with open(target, encoding="utf-8") as file:
            there = file.read()
    if there != text:
        print(f"{target}: is not what the results say; run benchmarks/results/make_readme.py")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
