#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Faults of vivid's devices while `glint track v4l2:` runs, each 20 times, cameras in turn: glint says what happened, the
others lose nothing, and the camera comes back."""
import tempfile

import fault_table
import guest_test
import vivid_rig

EACH = 20
DROPPED = "20 % of the buffers dropped for half a second"
GONE, FAILED = "was unplugged", "failed: the driver failed: Input/output error"
# A stream of vivid begins when it is started, unlike one of a camera with a trigger. So the streams are brought into step
# first, and faults come when the stream that follows them begins in step: so long after the fault.
AT_ONCE_MS, AFTER_RETRY_MS = 6, 507
IN_STEP_PERIODS, FIRST_PERIOD = 120, 60


class Kind:
    """A fault: the script's words at its beginning and its end, how long it lasts (the first time, and longer each time),
    when the stream begins anew, periods until the next fault, and what is said of it."""

    def __init__(self, name, begin, periods, says, end=(), lasts_ms=0, longer_ms=0, anew_ms=AT_ONCE_MS, lost=None):
        self.name, self.begin, self.end, self.says, self.lost = name, begin, end, says, lost
        self.lasts_ms, self.longer_ms, self.anew_ms, self.periods = lasts_ms, longer_ms, anew_ms, periods


KINDS = [
    Kind("buffer flagged as damaged", ["flag-error"], 15, None, lost=1),
    Kind("`QBUF` refused once", ["qbuf-error"], 15, None, lost=0),
    Kind(DROPPED, ["dropped-percent 20"], 30, "", end=["dropped-percent 0"], lasts_ms=500),
    Kind("fatal streaming error (`EIO`)", ["streaming-error"], 45, FAILED),
    Kind("the same, then `REQBUFS` refused", ["reqbufs-error", "streaming-error"], 45, FAILED),
    Kind("the same, then `STREAMON` refused", ["streamon-error", "streaming-error"], 60, FAILED, anew_ms=AFTER_RETRY_MS),
    # The device comes back when its last user has closed it.
    Kind("disconnected for 100 to 480 ms", ["disconnect {}"], 60, GONE, lasts_ms=100, longer_ms=20, anew_ms=AFTER_RETRY_MS),
    Kind("driver unbound, all cameras, for 300 to 680 ms", ["unbind {}"], 120, GONE, lasts_ms=300, longer_ms=20),
]


def planned():
    """(kind, camera, milliseconds at which it begins and ends)."""
    period = FIRST_PERIOD + 4 * IN_STEP_PERIODS
    for kind in KINDS:
        for number in range(EACH):
            begins_ms = period * vivid_rig.PERIOD_MS - kind.anew_ms
            yield kind, 1 + number % 4, begins_ms, begins_ms + kind.lasts_ms + kind.longer_ms * number
            period += kind.periods


def script():
    for camera in range(1, 5):
        at_ms = (FIRST_PERIOD + (camera - 1) * IN_STEP_PERIODS) * vivid_rig.PERIOD_MS - AT_ONCE_MS
        yield f"{at_ms:.3f} {camera} streaming-error"
    for kind, camera, begins_ms, ends_ms in planned():
        yield from (f"{begins_ms:.3f} {camera} {words.format(round(ends_ms - begins_ms))}" for words in kind.begin)
        yield from (f"{ends_ms:.3f} {camera} {words}" for words in kind.end)


def check_ledger(run, dropped, verdict):
    """What glint does not say while it happens, it says at the end, and it stands in the ledger."""
    lost_by_host = 0
    for number, camera in enumerate(run.summary["ledger"]["cameras"], 1):
        print(f"camera {number}: " + ", ".join(f"{count} {name}" for name, count in camera.items() if name != "name" and count))
        verdict.expect(camera["corrupt"] == EACH // 4, f"camera {number}: {camera['corrupt']} corrupt frames, {EACH // 4} flagged")
        note = [text for _, text in run.said if text.startswith(f"note: camera cam{number}: ")]
        verdict.expect(note and f"{EACH // 4} frames flagged by the driver" in note[0], f"camera {number}: the end says {note}")
        lost_by_host += camera["lost_by_host"]
    # Of frames that are in no set then, some came after three that were dropped: sets did not wait for them.
    verdict.expect(lost_by_host >= 0.7 * dropped, f"{lost_by_host} frames lost by the host, {dropped} missing while buffers are dropped")


def faults_of(done):
    """What was planned, at the times of the log: it has a row for each step of the script, and one for each end that is none."""
    steps = iter([row for row in done if row["event"] == "begin"][4:])
    ends = iter([row for row in done if row["event"] == "end"])
    happened = []
    for kind, camera, _, _ in planned():
        begun_ns = [next(steps)["time_ns"] for _ in kind.begin][0]
        ended_ns = [next(steps)["time_ns"] for _ in kind.end][:1] or [begun_ns]
        if kind.says == GONE:
            ended_ns = [next(ends)["time_ns"]]
        cameras = [1, 2, 3, 4] if kind.begin[0].startswith("unbind") else [camera]
        happened.append((kind, cameras, begun_ns, ended_ns[0]))
    overs_ns = [begun_ns for _, _, begun_ns, _ in happened[1:]] + [done[-1]["time_ns"] + 4e9]
    return [(kind, fault_table.Fault(kind.name, *at, over_ns, kind.says)) for (kind, *at), over_ns in zip(happened, overs_ns)]


def main():
    verdict = guest_test.Verdict()
    *_, last_ms = list(planned())[-1]
    with tempfile.TemporaryDirectory() as box:
        vivid_rig.run(box, {"script.txt": script()}, f"{vivid_rig.faults_command('script.txt', '/run/out/done.csv')} "
                                                     f"{vivid_rig.track_command(int((last_ms + 4000) / vivid_rig.PERIOD_MS))}")
        run = fault_table.Run(box)
        faults = faults_of(guest_test.read_csv(f"{box}/done.csv"))
    table = fault_table.FaultTable(run, vivid_rig.PERIOD_MS * 1e6, verdict)
    for kind, fault in faults:
        table.add(fault)
        lost = table.rows[kind.name].lost[-1]
        verdict.expect(kind.lost in (None, lost), f"{kind.name}: {lost} frames in no set, not {kind.lost}")
    table.show()
    check_ledger(run, sum(table.rows[DROPPED].lost), verdict)
    verdict.finish()


if __name__ == "__main__":
    main()
