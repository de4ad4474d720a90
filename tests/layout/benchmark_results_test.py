#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""benchmarks/results/make_readme.py on made-up results: what it writes, and what it refuses."""
import contextlib
import copy
import io
import json
import os
import sys
import tempfile
import unittest

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "benchmarks", "results"))
import make_readme  # noqa: E402


def row(blobs, p50_s):
    scene = {"cameras": 4, "width_px": 1280, "height_px": 800, "blobs": blobs, "noise_grey": 1.2}
    if p50_s is None:
        return {"scene": scene, "outcome": "FAIL", "problem": "differs"}
    return {"scene": scene, "outcome": "ok", "problem": "", "wall": {"p50_s": p50_s}}


def device(name, kind, rows, headlines=()):
    vulkan = None if kind == "cpu" else {"device_type": kind, "driver_name": "drv", "driver_info": "1.2"}
    return {"name": name, "software": kind == "software", "vulkan": vulkan, "rows": rows, "headlines": list(headlines)}


def result(*devices):
    return {"schema": {"name": "glint-bench", "version": 1}, "glint_version": "0.1.0", "glint_commit": "abc",
            "machine": {"processor": "Some | CPU", "logical_cores": 8}, "devices": list(devices)}


MOST = {"rate_hz": 90.0, "outcome": "ok", "cameras": 32, "at_limit": True}
SOFT = result(device("llvmpipe", "software", [row(0, 0.0005), row(20, 0.00061)], [{**MOST, "cameras": 9, "at_limit": False}]),
              device("cpu (2 threads)", "cpu", [row(20, 0.00007)]))
HARD = result(device("Zeta GPU", "discrete", [row(20, 0.0002), row(200, None)], [MOST]))


class MakeReadmeTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def put(self, path, content):
        full = os.path.join(self.folder, path)
        os.makedirs(os.path.dirname(full), exist_ok=True)
        with open(full, "w", encoding="utf-8") as file:
            file.write(content if isinstance(content, str) else json.dumps(content))

    def run_script(self, *arguments):
        out = io.StringIO()
        with contextlib.redirect_stdout(out):
            code = make_readme.main([*arguments, self.folder])
        return code, out.getvalue()

    def readme(self):
        with open(os.path.join(self.folder, "README.md"), encoding="utf-8") as file:
            return file.read()

    def rows(self):
        return [line for line in self.readme().splitlines() if line.startswith("|")][2:]

    def test_one_row_per_device_sorted_and_marked(self):
        self.put("mesa/llvmpipe.json", SOFT)
        self.put("zeta/gpu.json", HARD)
        self.assertEqual(self.run_script(), (0, ""))
        rows = self.rows()
        self.assertEqual(len(rows), 3)
        self.assertEqual(rows[0], "| Zeta GPU | discrete | drv 1.2 | Some \\| CPU, 8 cores | 0.1.0 (abc) |  | 0.200 | FAIL "
                                  "| 32 or more | [zeta/gpu.json](zeta/gpu.json) |")
        self.assertIn("| llvmpipe | **software, no GPU** |", rows[1])
        self.assertIn("| 0.500 | 0.610 |  | 9 |", rows[1])
        self.assertIn("| cpu (2 threads) | native, without Vulkan |", rows[2])
        self.assertIn("4 x 1280x800, 20 blobs", self.readme())

    def test_check_finds_a_stale_page(self):
        self.put("mesa/llvmpipe.json", SOFT)
        self.assertEqual(self.run_script("--check")[0], 1)
        self.run_script()
        self.assertEqual(self.run_script("--check"), (0, ""))
        changed = copy.deepcopy(SOFT)
        changed["devices"][0]["rows"][1]["wall"]["p50_s"] = 0.0007
        self.put("mesa/llvmpipe.json", changed)
        code, out = self.run_script("--check")
        self.assertEqual(code, 1)
        self.assertIn("is not what the results say", out)

    def test_no_results(self):
        self.assertEqual(self.run_script(), (0, ""))
        self.assertIn("There are none yet.", self.readme())

    def test_bad_results_are_named(self):
        no_wall = copy.deepcopy(SOFT)
        del no_wall["devices"][0]["rows"][0]["wall"]
        for content, text in [("{", "is damaged or no JSON"), ([], "is not a result of glint bench"),
                              ({"schema": {"name": "glint-bench", "version": 2}}, "is not a result of glint bench"),
                              (no_wall, "is not complete: KeyError('wall')"),
                              (json.dumps(SOFT) + " " * 200_000, "use glint bench -o json --no-samples")]:
            self.put("mesa/bad.json", content)
            code, out = self.run_script()
            self.assertEqual(code, 1)
            self.assertIn("mesa/bad.json: ", out)
            self.assertIn(text, out)


if __name__ == "__main__":
    unittest.main()
