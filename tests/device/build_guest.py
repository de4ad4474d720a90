#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Makes what run_in_guest.py boots, from Debian's packages, without installing any of them.

    build_guest.py [--folder DIR] [--force]      default DIR: build/guest in the repository

    DIR/vmlinuz     Debian's kernel
    DIR/initrd      busybox and kernel modules, v4l2loopback among them
    DIR/guest.json  what it was made of; with it there and this script unchanged, a second call does nothing

Exit code 77 with a line that starts with SKIPPED where a tool or package cannot be had; 1 instead of 77 if the
environment variable GLINT_REQUIRE names vm.
"""
import argparse
import fcntl
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys

import cpio

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
DEFAULT_FOLDER = os.path.join(ROOT, "build", "guest")
INSTALL = "run: host/install_packages vm"
TOOL_FOLDERS = os.environ.get("PATH", "") + ":/usr/sbin:/sbin"

# Loaded in every guest: the host's file system over virtio.
BASE_MODULES = ["virtio_pci", "9pnet_virtio", "9p"]
# Loaded on request.
DEVICE_MODULES = ["vivid", "uvcvideo", "vhci-hcd", "v4l2loopback", "uhid", "usbhid", "hid-generic", "dummy_hcd",
                  "libcomposite", "virtio_net"]


class Missing(Exception):
    """Something that this machine lacks; the text says what to do."""


def tool(name):
    path = shutil.which(name, path=TOOL_FOLDERS)
    if path is None:
        raise Missing(f"{name} is not installed; {INSTALL}")
    return path


def run(command, what, **options):
    """Output of a command; its own words if it fails."""
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **options)
    if done.returncode != 0:
        raise Missing(f"{what} failed: {' '.join(command)}\n{done.stdout.strip()[-2000:]}")
    return done.stdout


class Packages:
    """Debian packages by name, downloaded and unpacked below a folder."""

    def __init__(self, folder):
        self.downloads = os.path.join(folder, "packages")
        self.unpacked = os.path.join(folder, "unpacked")
        for path in (self.downloads, self.unpacked):
            os.makedirs(path, exist_ok=True)
        self.options = ["-o", "APT::Sandbox::User=root"] if os.geteuid() == 0 else []
        self.files = []

    def use_own_lists(self, folder):
        """Package lists of our own, for a machine whose own are missing or old; needs no rights."""
        for name in ("lists/partial", "cache/archives/partial"):
            os.makedirs(os.path.join(folder, "apt", name), exist_ok=True)
        self.options += ["-o", f"Dir::State::Lists={folder}/apt/lists", "-o", f"Dir::Cache={folder}/apt/cache"]
        run([tool("apt-get"), *self.options, "-q", "-o", "Acquire::Retries=3", "update"], "apt-get update")

    def kernel_release(self):
        """What the newest generic kernel is called, such as 6.1.0-56-amd64."""
        text = run([tool("apt-cache"), *self.options, "depends", "linux-image-amd64"], "looking for the kernel")
        found = re.search(r"Depends: linux-image-(\d\S*-amd64)\s", text)
        if not found:
            raise Missing("this system's package lists have no linux-image-amd64; Debian 12 has")
        return found.group(1)

    def kbuild_of(self, headers):
        text = run([tool("apt-cache"), *self.options, "depends", headers], "looking for linux-kbuild")
        found = re.search(r"Depends: (linux-kbuild-\S+)", text)
        if not found:
            raise Missing(f"{headers} names no linux-kbuild; Debian 12's does")
        return found.group(1)

    def fetch(self, names):
        run([tool("apt-get"), *self.options, "-q", "-o", "Acquire::Retries=3", "download", *names], "apt-get download",
            cwd=self.downloads)
        for name in sorted(os.listdir(self.downloads)):
            run([tool("dpkg"), "-x", os.path.join(self.downloads, name), self.unpacked], "dpkg -x")
            self.files.append(name)


def fetch_all(folder):
    """Downloads and unpacks kernel and headers; returns (Packages, release)."""
    def attempt(packages):
        release = packages.kernel_release()
        headers = f"linux-headers-{release}"
        common = headers[:-len("amd64")] + "common"
        packages.fetch([f"linux-image-{release}", headers, common, packages.kbuild_of(headers), "v4l2loopback-dkms"])
        return packages, release
    try:
        return attempt(Packages(folder))
    except Missing:
        packages = Packages(folder)
        packages.use_own_lists(folder)
        return attempt(packages)


def build_v4l2loopback(root, release):
    """Compiles v4l2loopback against the unpacked headers and puts it beside the kernel's own modules."""
    headers = f"{root}/usr/src/linux-headers-{release}"
    makefile = f"{headers}/Makefile"
    with open(makefile, encoding="utf-8") as file:
        text = file.read()
    with open(makefile, "w", encoding="utf-8") as file:
        file.write(text.replace(" /usr/src/", f" {root}/usr/src/"))
    sources = [name for name in os.listdir(f"{root}/usr/src") if name.startswith("v4l2loopback-")]
    source = f"{root}/usr/src/{sources[0]}"
    run([tool("make"), "-C", headers, f"M={source}", "modules"], "compiling v4l2loopback")
    home = f"{root}/lib/modules/{release}/extra"
    os.makedirs(home, exist_ok=True)
    shutil.copy(f"{source}/v4l2loopback.ko", home)


def load_order(root, release, module):
    """Files of a module and of all that it needs, in the order of loading."""
    text = run([tool("modprobe"), "-d", root, "-S", release, "--show-depends", module], f"looking for module {module}")
    return [line.split()[1] for line in text.splitlines() if line.startswith("insmod ")]


def write_initrd(path, root, release):
    """An archive with busybox, /modules/*.ko and /modules/order/NAME; run_in_guest.py adds what runs."""
    run([tool("depmod"), "-b", root, release], "depmod")
    busybox = tool("busybox")
    with open(busybox, "rb") as file:
        program = file.read()
    if b"/ld-linux" in program:
        raise Missing(f"{busybox} is not the static one; {INSTALL}")
    archive = cpio.Archive()
    for folder in ("bin", "dev", "proc", "sys", "host", "modules", "modules/order"):
        archive.folder(folder)
    archive.file("bin/busybox", program, 0o755)
    for applet in ("sh", "cat", "chroot", "cp", "cut", "dmesg", "echo", "ifconfig", "insmod", "ln", "ls", "mkdir",
                   "mount", "poweroff", "stty", "tail", "tr"):
        archive.link(f"bin/{applet}", "busybox")
    present = set()
    for module in BASE_MODULES + DEVICE_MODULES:
        names = []
        for file_path in load_order(root, release, module):
            name = os.path.basename(file_path)
            names.append(name)
            if name not in present:
                present.add(name)
                with open(file_path, "rb") as file:
                    archive.file(f"modules/{name}", file.read(), 0o644)
        archive.file(f"modules/order/{module}", ("\n".join(names) + "\n").encode(), 0o644)
    archive.file("modules/base", ("\n".join(BASE_MODULES) + "\n").encode(), 0o644)
    archive.write(path)


def recipe():
    """Changes when this script or what it packs changes."""
    digest = hashlib.sha256()
    for name in ("build_guest.py", "cpio.py"):
        with open(os.path.join(HERE, name), "rb") as file:
            digest.update(file.read())
    return digest.hexdigest()


def build(folder=DEFAULT_FOLDER, force=False):
    """Makes the guest where it is not there yet; returns the path of guest.json. Raises Missing."""
    os.makedirs(folder, exist_ok=True)
    stamp = os.path.join(folder, "guest.json")
    with open(os.path.join(folder, "build.lock"), "w", encoding="utf-8") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not force and os.path.exists(stamp):
            with open(stamp, encoding="utf-8") as file:
                if json.load(file).get("recipe") == recipe():
                    return stamp
        for name in ("unpacked", "packages"):
            shutil.rmtree(os.path.join(folder, name), ignore_errors=True)
        packages, release = fetch_all(folder)
        root = packages.unpacked
        build_v4l2loopback(root, release)
        write_initrd(os.path.join(folder, "initrd"), root, release)
        shutil.copy(f"{root}/boot/vmlinuz-{release}", os.path.join(folder, "vmlinuz"))
        shutil.rmtree(root)
        shutil.rmtree(packages.downloads)
        with open(stamp, "w", encoding="utf-8") as file:
            json.dump({"recipe": recipe(), "kernel": release, "packages": packages.files}, file, indent=2)
    return stamp


def say_missing(error):
    """Prints why the tests cannot run here; returns the exit code for it."""
    if "vm" in re.split(r"[,\s]+", os.environ.get("GLINT_REQUIRE", "")):
        print(f"{error}\n(GLINT_REQUIRE names vm, so this is a failure)", file=sys.stderr)
        return 1
    print(f"SKIPPED: {error}")
    return 77


def main():
    parser = argparse.ArgumentParser(description="Makes the kernel and initrd that run_in_guest.py boots.")
    parser.add_argument("--folder", default=DEFAULT_FOLDER)
    parser.add_argument("--force", action="store_true", help="make it anew")
    arguments = parser.parse_args()
    try:
        print(build(os.path.abspath(arguments.folder), arguments.force))
    except Missing as error:
        return say_missing(error)
    return 0


if __name__ == "__main__":
    sys.exit(main())
