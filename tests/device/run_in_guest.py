#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Runs a command of this machine under a real kernel with real drivers, in QEMU, as root.

    run_in_guest.py [--virtual-time] [--network] [--module "NAME OPTION=VALUE ..."]... [--copy FILE]... [--out DIR]
                    [--env NAME=VALUE]... [--timeout SECONDS] [--memory-mib N] [--log FILE] -- COMMAND ARGUMENT...

The guest sees this machine's files read-only, its own /dev, /sys and /proc, and an empty /run. COMMAND's program and
each --copy FILE, with the libraries that they link, are copied into memory first; the command finds them by their bare
names, starts in that folder, and leaves in $OUT what is wanted in --out DIR. Prints what the command prints and exits
with its code; 124: out of time; 125: the guest itself failed, and its log is shown; 77: this machine lacks something
(1 if GLINT_REQUIRE names vm).

--virtual-time: the guest's clock counts instructions, one a nanosecond, and jumps while the guest is idle. Rates and
times may be asserted in it, whatever else this machine does. Never sleep for readiness there: shake hands.
--network: the guest reaches servers on this machine at 10.0.2.2; not together with --virtual-time, which would not wait
for their answers.
"""
import argparse
import fcntl
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time

import build_guest
import cpio

TIMED_OUT, GUEST_FAILED = 124, 125
# Without string copies said to be fast: counted time takes one instruction for each byte of them.
CPU = "max,-erms,-fsrm"


def libraries_of(program):
    """Shared libraries that a program links, the loader aside; none for scripts and static programs."""
    done = subprocess.run(["ldd", program], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=False)
    return re.findall(r"=> (/\S+)", done.stdout) if done.returncode == 0 else []


def files_to_copy(command, extra):
    """(path on the host, path below the guest's job folder) of everything that must lie in memory."""
    program = command[0] if "/" in command[0] else shutil.which(command[0])
    copies = {}
    for path in [program, *extra]:
        if path is None or not os.path.isfile(path):
            raise build_guest.Missing(f"no such file: {path or command[0]}")
        copies[os.path.abspath(path)] = os.path.basename(path)
        for library in libraries_of(path):
            copies[library] = "lib/" + os.path.basename(library)
    return copies


def job_archive(arguments, command, copies):
    """guest_init.sh and what it expects in /job, as an archive that follows the initrd."""
    words = [os.path.basename(command[0]), *command[1:]]
    script = "\n".join([
        "export PATH=/run/job:/usr/local/bin:/usr/bin:/bin:/usr/sbin:/sbin HOME=/run/tmp TMPDIR=/run/tmp OUT=/run/out",
        "export LD_LIBRARY_PATH=/run/job/lib LD_BIND_NOW=1 LANG=C.UTF-8",
        *[f"export {shlex.quote(variable)}" for variable in arguments.env],
        "cd /run/job",
        "exec " + shlex.join(words), ""])
    archive = cpio.Archive()
    with open(os.path.join(build_guest.HERE, "guest_init.sh"), "rb") as file:
        archive.file("init", file.read(), 0o755)
    archive.folder("job")
    archive.file("job/command", script.encode(), 0o755)
    archive.file("job/modules", "".join(line + "\n" for line in arguments.module).encode(), 0o644)
    archive.file("job/copy", "".join(f"{os.path.realpath(a)} {b}\n" for a, b in copies.items()).encode(), 0o644)
    if arguments.out:
        archive.file("job/out", b"", 0o644)
    if arguments.network:
        archive.file("job/network", b"", 0o644)
    return archive.bytes()


def qemu_command(arguments, folder, box):
    """One processor and counted time, or as many as this machine has and its clock."""
    cores = min(4, os.cpu_count() or 1)
    time_and_cores = (["-accel", "tcg,thread=single", "-icount", "shift=0,sleep=off", "-smp", "1"]
                      if arguments.virtual_time else ["-accel", "tcg,thread=multi", "-smp", str(cores)])
    share = "local,security_model=none,multidevs=remap"
    command = [
        build_guest.tool("qemu-system-x86_64"), *time_and_cores, "-cpu", CPU, "-m", str(arguments.memory_mib),
        "-nodefaults", "-no-user-config", "-display", "none", "-no-reboot",
        "-kernel", os.path.join(folder, "vmlinuz"), "-initrd", os.path.join(box, "initrd"),
        "-append", "console=ttyS0 panic=-1 mitigations=off nokaslr",
        "-virtfs", f"{share},path=/,mount_tag=host,readonly=on"]
    if arguments.out:
        command += ["-virtfs", f"{share},path={os.path.abspath(arguments.out)},mount_tag=out"]
    if arguments.network:
        command += ["-netdev", "user,id=net", "-device", "virtio-net-pci,netdev=net,romfile="]
    for name in ("log", "stdout", "stderr", "code"):
        command += ["-serial", f"file:{box}/{name}"]
    return command


class Echo:
    """Passes on what has been added to a file since the last look."""

    def __init__(self, path, stream):
        self._file = open(path, "rb")
        self._stream = stream

    def pass_on(self):
        text = self._file.read()
        if text:
            self._stream.buffer.write(text)
            self._stream.flush()


def run_qemu(command, box, timeout_s):
    """True if QEMU ended by itself in time."""
    for name in ("log", "stdout", "stderr", "code"):
        open(f"{box}/{name}", "wb").close()
    echoes = [Echo(f"{box}/stdout", sys.stdout), Echo(f"{box}/stderr", sys.stderr)]
    qemu_log = open(f"{box}/qemu", "wb")
    qemu = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=qemu_log, stderr=subprocess.STDOUT)
    try:
        latest = time.monotonic() + timeout_s
        while qemu.poll() is None and time.monotonic() < latest:
            time.sleep(0.05)
            for echo in echoes:
                echo.pass_on()
        ended = qemu.poll() is not None
    finally:
        if qemu.poll() is None:
            qemu.kill()
        qemu.wait()
        for echo in echoes:
            echo.pass_on()
    return ended


def contents(path):
    with open(path, "rb") as file:
        return file.read().decode(errors="replace")


def judge(ended, box, arguments):
    """Exit code of the run; the log is shown where the guest is to blame."""
    log = contents(f"{box}/log") + contents(f"{box}/qemu")
    with open(arguments.log, "w", encoding="utf-8") as file:
        file.write(log)
    answer = contents(f"{box}/code").split()
    code = int(answer[0]) if answer and answer[0].isdigit() else GUEST_FAILED
    if not ended:
        code = TIMED_OUT
    if code != 0:
        why = {TIMED_OUT: f"not done after {arguments.timeout:g} s", GUEST_FAILED: "the guest failed"}.get(
            code, f"the command ended with {code}")
        shown = 60 if code in (TIMED_OUT, GUEST_FAILED) else 15
        tail = "\n".join(log.replace("\r", "").splitlines()[-shown:])
        print(f"run_in_guest: {why}; the end of {arguments.log}:\n{tail}", file=sys.stderr)
    return code


def run(arguments, command):
    folder = os.path.abspath(arguments.folder)
    build_guest.tool("qemu-system-x86_64")
    build_guest.build(folder)
    arguments.log = arguments.log or os.path.join(folder, "last-run.log")
    if arguments.out:
        os.makedirs(arguments.out, exist_ok=True)
    copies = files_to_copy(command, arguments.copy)
    # One guest at a time: each takes all that a small machine has.
    with open(os.path.join(folder, "run.lock"), "w", encoding="utf-8") as lock, \
            tempfile.TemporaryDirectory(prefix="glint-guest-") as box:
        fcntl.flock(lock, fcntl.LOCK_EX)
        with open(f"{box}/initrd", "wb") as initrd:
            with open(os.path.join(folder, "initrd"), "rb") as base:
                shutil.copyfileobj(base, initrd)
            initrd.write(job_archive(arguments, command, copies))
        ended = run_qemu(qemu_command(arguments, folder, box), box, arguments.timeout)
        return judge(ended, box, arguments)


def main():
    if "--" not in sys.argv:
        print(__doc__, file=sys.stderr)
        return 2
    split = sys.argv.index("--")
    parser = argparse.ArgumentParser(usage=__doc__)
    parser.add_argument("--virtual-time", action="store_true")
    parser.add_argument("--network", action="store_true")
    parser.add_argument("--module", action="append", default=[])
    parser.add_argument("--copy", action="append", default=[])
    parser.add_argument("--env", action="append", default=[], metavar="NAME=VALUE")
    parser.add_argument("--out")
    parser.add_argument("--timeout", type=float, default=300.0)
    parser.add_argument("--memory-mib", type=int, default=2048)
    parser.add_argument("--folder", default=build_guest.DEFAULT_FOLDER)
    parser.add_argument("--log")
    arguments = parser.parse_args(sys.argv[1:split])
    command = sys.argv[split + 1:]
    if not command:
        parser.error("no command after --")
    if arguments.network and arguments.virtual_time:
        parser.error("--network and --virtual-time exclude each other")
    try:
        return run(arguments, command)
    except build_guest.Missing as error:
        return build_guest.say_missing(error)


if __name__ == "__main__":
    sys.exit(main())
