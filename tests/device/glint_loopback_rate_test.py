#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""`glint track v4l2:` on four v4l2loopback cameras, 1280x800 grey, at the highest rate that the guest's processor manages:
2,000 pulses, and every frame of every camera is in its set."""
import json
import tempfile

import glint_live_test
import guest_test

PULSES, RATE_HZ, TICKS = 2000, 250, 40
# v4l2loopback says 30 Hz whatever the rate at which it is fed.
RIG = glint_live_test.RIG.format(rate_hz=RATE_HZ).replace('"mjpeg"', '"grey"').replace("rate_hz = 90.0", "rate_hz = 30.0")


def main():
    verdict = guest_test.Verdict()
    with tempfile.TemporaryDirectory() as box:
        glint_live_test.prepare(box, TICKS)
        with open(f"{box}/rig.toml", "w", encoding="utf-8") as file:
            file.write(RIG)
        names = ["rig.toml", "calibration.toml", "frames.jpgs", *[f"cam{n}.pgm" for n in range(1, 5)]]
        guest_test.run(
            [guest_test.program("loopback_feeder"), "--rate", str(RATE_HZ), "--frames", "frames.jpgs", "--device",
             *guest_test.LOOPBACK_NODES, "--", "sh", "-c",
             f"glint track v4l2:{','.join(guest_test.LOOPBACK_NODES)} --rig rig.toml --device cpu --background /run/job "
             f"--ticks {PULSES} --quiet --output jsonl:/run/out/sets.jsonl --summary /run/out/summary.json"],
            modules=[guest_test.LOOPBACK_MODULE], copy=[guest_test.program("glint"), *[f"{box}/{name}" for name in names]],
            out=box, seconds=900)
        with open(f"{box}/sets.jsonl", encoding="utf-8") as file:
            sets = [json.loads(line) for line in file]
        with open(f"{box}/summary.json", encoding="utf-8") as file:
            summary = json.load(file)
    for camera in summary["ledger"]["cameras"]:
        print(", ".join(f"{key} {value}" for key, value in camera.items()))
        verdict.expect(camera["used"] == summary["ledger"]["pulses"] == PULSES, f"{camera['name']}: {camera['used']} of {PULSES}")
    verdict.expect([one["tick"] for one in sets] == list(range(PULSES)), "sets are missing")
    verdict.expect(all(one["cameras"] == [1, 2, 3, 4] for one in sets), "a set lacks a camera")
    points = [len(one["points"]) for one in sets[10:]]
    verdict.expect(min(points) >= 15, f"a set with {min(points)} points of 20 markers")
    seconds = (sets[-1]["time_ns"] - sets[0]["time_ns"]) * 1e-9
    latency, detection = summary["stamp_to_output"], summary["detection"]
    print(f"{(len(sets) - 1) / seconds:.2f} sets a second for {seconds:.1f} s, {min(points)} to {max(points)} points each; driver's "
          f"stamp to output p50 {latency['p50_s'] * 1e3:.2f} ms, p99 {latency['p99_s'] * 1e3:.2f} ms, most "
          f"{latency['max_s'] * 1e3:.2f} ms; detection p50 {detection['p50_s'] * 1e3:.2f} ms")
    verdict.expect(abs((len(sets) - 1) / seconds - RATE_HZ) < 0.01 * RATE_HZ, "not at that rate")
    verdict.finish()


if __name__ == "__main__":
    main()
