#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Checks that the folders of glint keep to the include table, and the files to the house rules.

    check_layers.py [ROOT]      prints `file:line: text` for each finding; exit code 1 if there is one
"""
import os
import re
import sys

# Which module may include which, besides itself; every host module may also include host/base. A row is as
# tight as the module allows today: adding a word to it is a decision, not a repair.
TABLE = {
    "shaders/interface": [],
    "gpu": ["shaders/interface"],
    "firmware/protocol": [],
    "firmware/core": ["firmware/protocol"],
    "firmware/rp2040": ["firmware/core", "firmware/protocol"],
    "usb-sync": ["firmware/protocol"],
    "host/base": [],
    "host/files": [],
    "host/page": [],
    "host/frames": ["gpu"],
    "host/assemble": ["host/frames", "gpu"],
    "host/sync": ["usb-sync", "firmware/protocol", "host/assemble", "host/frames", "gpu"],
    "host/geometry": ["gpu"],
    "host/capture": ["host/frames", "host/assemble", "gpu"],
    "host/sim": ["host/frames", "host/geometry", "gpu"],
    "host/resolve": ["gpu", "host/geometry", "shaders/interface"],
    "host/match": ["gpu", "host/geometry", "host/resolve", "shaders/interface"],
    "host/track": ["host/geometry", "host/match"],
    "host/body": ["host/geometry", "host/match", "host/track"],
    "host/health": ["host/geometry", "host/match", "shaders/interface"],
    "host/output": ["host/geometry", "host/page", "host/track", "host/match", "host/body", "shaders/interface"],
    "host/config": ["host/files", "gpu", "host/match", "host/track", "host/body", "host/geometry"],
    "host/target": ["host/geometry", "shaders/interface"],
    "host/calibrate": ["host/files", "host/geometry", "host/page", "host/target"],
    "host/bench": ["gpu"],
    "host/realtime": [],
    "host/doctor": ["host/capture", "host/frames", "host/realtime", "gpu"],
    "host/pipeline": ["gpu", "host/frames", "host/assemble", "host/geometry", "host/capture", "host/match", "host/track",
                      "host/body", "host/health"],
}
for _module, _row in TABLE.items():
    if _module.startswith("host/") and _module != "host/base":
        _row.append("host/base")

EVERYTHING = ("host/apps", "tests", "benchmarks")  # may include all of the above

# Modules that have no standard library, and the headers that the compiler itself brings.
BARE = {
    "shaders/interface": ["cstdint"],
    "firmware/protocol": ["stdint.h"],
    "firmware/core": ["stddef.h", "stdint.h"],
    "firmware/rp2040": ["stddef.h", "stdint.h"],
}

HEADERS_ONLY = ("shaders/interface", "firmware/protocol")  # folders of headers, which are no targets

# Third-party headers that only some folders may see (tests may see all).
RESERVED = [
    (r"(vulkan|vk_mem_alloc)\b", "Vulkan", ["gpu/vulkan"]),
    (r"toml(\+\+|plusplus)", "toml++", ["host/config"]),
    (r"lib(av\w+|sw\w+)/", "FFmpeg", ["host/capture"]),
    (r"linux/videodev2", "V4L2", ["host/capture"]),
    (r"opencv", "OpenCV", ["benchmarks", "host/target"]),
    (r"ceres/", "Ceres", ["host/calibrate"]),
    (r"CLI/|CLI11", "CLI11", ["host/apps", "benchmarks"]),
    (r"benchmark/", "Google Benchmark", ["benchmarks"]),
    (r"hidapi/", "hidapi", ["usb-sync"]),
    (r"libusb", "libusb", ["usb-sync"]),
    (r"gtest|gmock", "GoogleTest", []),
]
NOT_EVEN_TESTS = {"OpenCV"}

SOURCES = (".cpp", ".hpp", ".c", ".h", ".S", ".comp", ".glsl", ".py", ".js")
SCRIPTS = (".sh", ".cmake", ".ld")
LONGEST = 600
VAGUE = re.compile(r"(?<![a-z])(utils?|common|helpers?|managers?)(?![a-z])", re.IGNORECASE)
VAGUE_TYPE = re.compile(r"^\s*(?:class|struct|namespace|enum class)\s+(\w*(?:Utils?|Common|Helper|Manager)\w*)")
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^>"]+)[>"]')
SKIPPED_FOLDERS = {".git", "build", "glint-out", "__pycache__", "node_modules", ".cache", ".vscode", ".idea"}


def module_of(path):
    """The module that a file belongs to: the longest table entry or free folder that holds it."""
    for name in sorted([*TABLE, *EVERYTHING, "shaders"], key=len, reverse=True):
        if path.startswith(name + "/"):
            return name
    return None


def cycle_in(table):
    """Modules along a cycle, or [] if there is none."""
    done, path = set(), []

    def walk(module):
        if module in path:
            return path[path.index(module):] + [module]
        if module in done:
            return []
        path.append(module)
        for other in table.get(module, []):
            found = walk(other)
            if found:
                return found
        path.pop()
        done.add(module)
        return []

    for module in table:
        found = walk(module)
        if found:
            return found
    return []


def all_files(root):
    for folder, folders, names in os.walk(root):
        folders[:] = sorted(f for f in folders if f not in SKIPPED_FOLDERS and not f.startswith("build-"))
        for name in sorted(names):
            yield os.path.relpath(os.path.join(folder, name), root).replace(os.sep, "/")


def check_own_header(path, includes, files):
    """A .cpp with a header of its own includes that one first: so each header is known to stand alone."""
    own = os.path.splitext(path)[0] + ".hpp"
    if not path.endswith(".cpp") or own not in files:
        return
    if not includes or includes[0][2] != own:
        line = includes[0][0] if includes else 1
        yield path, line, f'the first include must be "{own}"'


def check_includes(path, includes, files):
    module = module_of(path)
    for line, mark, target in includes:
        for pattern, library, homes in RESERVED:
            if not re.match(pattern, target):
                continue
            at_home = any(path.startswith(home + "/") for home in homes)
            in_tests = path.startswith("tests/") and library not in NOT_EVEN_TESTS
            if not at_home and not in_tests:
                yield path, line, f"{library} may be included only in {', '.join(homes + ['tests'] * (not homes))}"
        if module is None:
            continue
        if module in BARE and (mark, target) not in [("<", header) for header in BARE[module]]:
            own = mark == '"' and module not in HEADERS_ONLY
            if not own:
                yield path, line, f"{module} may include {' and '.join(f'<{h}>' for h in BARE[module])} only, not {target}"
                continue
        if mark == "<":
            continue
        full = target
        if module == "shaders":  # glslang searches beside the including file too
            beside = os.path.normpath(os.path.join(os.path.dirname(path), target)).replace(os.sep, "/")
            full = beside if beside in files else target
            if not full.startswith("shaders/"):
                yield path, line, f"shaders may not include {target}"
            continue
        other = module_of(full)
        if other is None or full not in files:
            spirv = full.startswith("shaders/") and full.endswith(".spv.h") and path.startswith("gpu/vulkan/")
            if spirv or full + ".in" in files:
                continue  # made by the build
            if other is not None or "/" not in full:
                yield path, line, f'no such file: "{full}"; includes are paths in the repository'
            continue
        if other == "tests" and module != "tests":
            yield path, line, "nothing but tests may include tests"
        elif other == "benchmarks" and module != "benchmarks":
            yield path, line, "nothing but benchmarks may include benchmarks"
        elif other == "host/apps" and module not in EVERYTHING:
            yield path, line, f"{module} may not include host/apps"
        elif module not in EVERYTHING and other != module and other not in TABLE[module]:
            yield path, line, f"{module} may not include {other}"


def target_of(module):
    return "glint_" + module.split("/")[-1]


def check_cmake(path, text):
    """glint_module(... DEPENDS ...) names exactly the modules of the table row."""
    module = os.path.dirname(path)
    if module not in TABLE:
        return
    code = re.sub(r"#[^\n]*", "", text)
    call = re.search(r"glint_module\(([^)]*)\)", code)
    if not call:
        return
    line = code[:call.start()].count("\n") + 1
    words = call.group(1).split()
    if words[0] != target_of(module):
        yield path, line, f"the target of {module} is named {target_of(module)}, not {words[0]}"
    modules = {target_of(m) for m in TABLE if m not in HEADERS_ONLY}
    linked = set(words[1:]) & modules
    for more in re.finditer(r"target_link_libraries\(([^)]*)\)", code):
        linked |= set(more.group(1).split()[1:]) & modules
    row = {target_of(m) for m in TABLE[module] if m not in HEADERS_ONLY}
    for name in sorted(linked - row):
        yield path, line, f"{module} may not depend on {name}: it is not in its table row"
    for name in sorted(row - linked):
        yield path, line, f"DEPENDS lacks {name}, which is in the table row of {module}"


def check_file(root, path, files):
    name = os.path.basename(path)
    extension = os.path.splitext(name)[1]
    stem_and_folders = path[:len(path) - len(extension)] if extension else path
    vague = VAGUE.search(stem_and_folders.replace("_", " ").replace("-", " "))
    if vague and not path.startswith("docs/"):
        yield path, 1, f"'{vague.group(1)}' in a name says nothing about what is inside"
    is_script = extension in SCRIPTS or name == "CMakeLists.txt"
    if extension not in SOURCES and not is_script:
        return
    with open(os.path.join(root, path), encoding="utf-8") as file:
        text = file.read()
    lines = text.split("\n")
    if "SPDX-License-Identifier: " not in "\n".join(lines[:2]):
        yield path, 1, "the first line must name the licence: SPDX-License-Identifier: MIT"
    if name == "CMakeLists.txt":
        yield from check_cmake(path, text)
    if extension not in SOURCES:
        return
    count = text.count("\n")
    if count > LONGEST:
        yield path, LONGEST + 1, f"{count} lines; a file has at most {LONGEST}"
    if extension in (".py", ".js"):
        return
    includes = []
    for number, line in enumerate(lines, 1):
        found = INCLUDE.match(line)
        if found:
            includes.append((number, found.group(1), found.group(2)))
        vague = VAGUE_TYPE.match(line)
        if vague:
            yield path, number, f"'{vague.group(1)}' says nothing about what it is for"
    yield from check_own_header(path, includes, files)
    yield from check_includes(path, includes, files)


def check(root, table=None):
    """All findings in the tree below `root`, as (file, line, text)."""
    findings = []
    cycle = cycle_in(TABLE if table is None else table)
    if cycle:
        findings.append(("tests/layout/check_layers.py", 1, "the table has a cycle: " + " -> ".join(cycle)))
    files = set(all_files(root))
    for path in sorted(files):
        findings.extend(check_file(root, path, files))
    return findings


def main():
    root = sys.argv[1] if len(sys.argv) > 1 else os.path.join(os.path.dirname(__file__), "..", "..")
    findings = check(os.path.abspath(root))
    for path, line, text in findings:
        print(f"{path}:{line}: {text}")
    print(f"{len(findings)} finding{'' if len(findings) == 1 else 's'}")
    return 1 if findings else 0


if __name__ == "__main__":
    sys.exit(main())
