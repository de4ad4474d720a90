#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What a stream of vivid can begin with: a driver that refuses to start, which glint says by the camera's name, and
sequence numbers and time stamps that wrap or lie ahead, of which no frame is lost. Each 20 times."""
import tempfile

import fault_table
import guest_test
import vivid_rig

REFUSED_TIMES = 20
# Runs, each with four cameras; the stamps wrap after 16 s.
WRAPS, WRAP_SETS, STAMP_SETS = 5, 560, 60
RUNS = {
    "sequence and 64-bit time stamps wrap": (["wrap-sequence 1", "wrap-timestamp 1"], WRAPS, WRAP_SETS),
    "sequence and 32-bit time stamps wrap": (["wrap-sequence 1", "wrap-timestamp 2"], WRAPS, WRAP_SETS),
    "stamps of the start of exposure": (["wrap-timestamp 0", "timestamp-source 1"], WRAPS, STAMP_SETS),
    "stamps of the end of the frame, ahead of it": (["wrap-timestamp 0", "timestamp-source 0"], WRAPS, STAMP_SETS),
}


def refused_script(kind, number):
    return [f"start {1 + number % 4} {kind}"]


def main():
    verdict = guest_test.Verdict()
    scripts, commands = {}, []
    for index, (words, times, sets) in enumerate(RUNS.values()):
        scripts[f"run{index}.txt"] = [f"start {camera} {word}" for camera in range(1, 5) for word in words]
        for turn in range(times):
            out = f"/run/out/{index}-{turn}"
            commands.append(f"mkdir {out} && {vivid_rig.faults_command(f'run{index}.txt', out + '/done.csv')} "
                            f"{vivid_rig.track_command(sets, out)} || exit 1")
    for kind in ("streamon-error", "reqbufs-error"):
        for number in range(REFUSED_TIMES):
            scripts[f"{kind}{number}.txt"] = refused_script(kind, number)
            out = f"/run/out/{kind}{number}"
            commands.append(f"mkdir {out}; {vivid_rig.faults_command(f'{kind}{number}.txt', out + '/done.csv')} "
                            f"{vivid_rig.track_command(3, out)} 2>/dev/null; echo $? > {out}/code")
    with tempfile.TemporaryDirectory() as box:
        vivid_rig.run(box, {**scripts, "all.sh": commands}, "sh all.sh")
        for index, (name, (_, times, sets)) in enumerate(RUNS.items()):
            runs = [fault_table.Run(f"{box}/{index}-{turn}") for turn in range(times)]
            check_runs(name, runs, sets, verdict)
        for kind in ("streamon-error", "reqbufs-error"):
            check_refused(kind, box, verdict)
    verdict.finish()


def check_runs(name, runs, sets, verdict):
    used = lost = 0
    for run in runs:
        used += sum(camera["used"] for camera in run.summary["ledger"]["cameras"])
        lost += sum(1 for _ in run.missing())
        verdict.expect(not run.said, f"{name}: is told: {run.said}")
        times = [one["time_ns"] for one in run.sets]
        verdict.expect(times == sorted(times), f"{name}: time goes backwards")
    latency = runs[0].summary["stamp_to_output"]
    print(f"{name}: {4 * len(runs)} times, {used} frames used, {lost} lost; stamps taken as {latency['stamp']}, "
          f"to output p50 {latency['p50_s'] * 1e3:.2f} ms")
    verdict.expect(used == 4 * sets * len(runs) and lost == 0, f"{name}: {used} frames used of {4 * sets * len(runs)}")


def check_refused(kind, box, verdict):
    said = {}
    for number in range(REFUSED_TIMES):
        folder = f"{box}/{kind}{number}"
        with open(f"{folder}/code", encoding="utf-8") as file:
            code = int(file.read())
        with open(f"{folder}/said.txt", encoding="utf-8") as file:
            text = " ".join(line.partition(" ")[2].strip() for line in file)
        text = text.replace(f"cam{1 + number % 4}", "NAME").replace(f"/dev/video{number % 4}", "NODE")
        said[(code, text)] = said.get((code, text), 0) + 1
    for (code, text), times in said.items():
        print(f"{kind} at the start: {times} times exit code {code}, said: {text or 'nothing'}")
        # One refusal of pointers is no failure: the driver's own memory is asked for next.
        wanted = code == 0 if kind == "reqbufs-error" else code == 1 and "NAME (NODE): cannot be started" in text
        verdict.expect(wanted, f"{kind}: ended with {code}: {text}")


if __name__ == "__main__":
    main()
