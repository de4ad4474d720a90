#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""docs/dependencies.tsv is well-formed, and every library that CMake looks for is named in it."""
import os
import re
import sys

ROOT = os.path.abspath(os.path.join(os.path.dirname(__file__), "..", ".."))
TABLE = "docs/dependencies.tsv"
GROUPS = {"run", "build", "target", "test", "bench", "dev", "board", "vm", "guest"}
COLUMNS = ["group", "package", "name", "licence", "why"]
# What find_package and pkg_check_modules call it, and the Debian package that has it.
PACKAGE_OF = {
    "Vulkan": "libvulkan-dev", "Eigen3": "libeigen3-dev", "PkgConfig": "pkg-config", "GTest": "libgtest-dev",
    "tomlplusplus": "libtomlplusplus-dev", "CLI11": "libcli11-dev", "nlohmann_json": "nlohmann-json3-dev",
    "libavformat": "libavformat-dev", "libavcodec": "libavcodec-dev", "libavutil": "libavutil-dev",
    "libswscale": "libswscale-dev", "yaml-cpp": "libyaml-cpp-dev", "pugixml": "libpugixml-dev",
    "libturbojpeg": "libturbojpeg0-dev", "libjpeg": "libjpeg62-turbo-dev", "libpng": "libpng-dev", "PNG": "libpng-dev",
    "hidapi-hidraw": "libhidapi-dev", "hidapi-libusb": "libhidapi-dev", "libusb-1.0": "libusb-1.0-0-dev",
    "umockdev-1.0": "libumockdev-dev",
    "Ceres": "libceres-dev", "OpenCV": "libopencv-calib3d-dev", "benchmark": "libbenchmark-dev", "Python3": "python3",
}
PART_OF_CMAKE = {"Threads"}


def rows():
    with open(os.path.join(ROOT, TABLE), encoding="utf-8") as file:
        for number, line in enumerate(file, 1):
            if line.strip() and not line.startswith("#"):
                yield number, line.rstrip("\n").split("\t")


def main():
    findings, packages = [], {}
    for number, fields in rows():
        where = f"{TABLE}:{number}"
        if fields == COLUMNS:
            continue
        if len(fields) != len(COLUMNS) or not all(field.strip() for field in fields):
            findings.append(f"{where}: expected {len(COLUMNS)} filled columns: {', '.join(COLUMNS)}")
            continue
        if fields[0] not in GROUPS:
            findings.append(f"{where}: unknown group {fields[0]}")
        if fields[1] in packages:
            findings.append(f"{where}: {fields[1]} stands in line {packages[fields[1]]} already")
        packages[fields[1]] = number

    for folder, folders, names in os.walk(ROOT):
        folders[:] = [f for f in folders if f not in (".git", "build") and not f.startswith("build-")]
        if "CMakeLists.txt" not in names:
            continue
        path = os.path.join(folder, "CMakeLists.txt")
        with open(path, encoding="utf-8") as file:
            text = re.sub(r"#[^\n]*", "", file.read())
        for call in re.finditer(r"(find_package|pkg_check_modules|pkg_search_module)\(([^)]*)\)", text):
            number = text[:call.start()].count("\n") + 1
            words = [re.split(r"[<>=]", word)[0] for word in call.group(2).split()]
            if call.group(1) == "find_package":
                wanted = words[:1]
            else:
                wanted = [w for w in words[1:] if w not in ("REQUIRED", "QUIET", "IMPORTED_TARGET", "GLOBAL")]
            for name in wanted:
                if name not in PART_OF_CMAKE and PACKAGE_OF.get(name) not in packages:
                    findings.append(f"{os.path.relpath(path, ROOT)}:{number}: {name} is not in {TABLE}")
    print("\n".join(findings) if findings else f"{len(packages)} packages, all in order")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
