#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The guest boots, loads vivid, and shows its four capture nodes to a program of this machine."""
import guest_test

names = guest_test.run(
    ["/bin/sh", "-c", "uname -r; for n in /sys/class/video4linux/video*; do test -c /dev/${n##*/} && cat $n/name; done"],
    modules=["vivid n_devs=4 node_types=0x1,0x1,0x1,0x1"], virtual_time=False).split()
print(" ".join(names))
verdict = guest_test.Verdict()
verdict.expect(names[1:] == [f"vivid-00{n}-vid-cap" for n in range(4)], f"the nodes are {names[1:]}")
verdict.expect(names[0].endswith("-amd64"), f"the kernel is {names[0]}, not Debian's")
verdict.finish()
