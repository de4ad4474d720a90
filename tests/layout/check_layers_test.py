#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Plants one violation of each rule in a made-up tree: check_layers.py must find it, and nothing else."""
import os
import tempfile
import unittest

import check_layers

SPDX = "// SPDX-License-Identifier: MIT\n"
GOOD = {
    "shaders/interface/blob.h": SPDX + "#include <cstdint>\n",
    "shaders/lib/find.glsl": SPDX,
    "shaders/label.comp": SPDX + '#include "lib/find.glsl"\n#include "shaders/interface/blob.h"\n',
    "gpu/detector.hpp": SPDX + '#include <vector>\n#include "shaders/interface/blob.h"\n',
    "gpu/vulkan/context.cpp": SPDX + "#include <vulkan/vulkan_raii.hpp>\n#include \"shaders/label.spv.h\"\n",
    "gpu/CMakeLists.txt": "# SPDX-License-Identifier: MIT\n"
                          "glint_module(glint_gpu\n  SOURCES a.cpp\n  DEPENDS\n  PRIVATE Threads::Threads)\n",
    "host/base/ids.hpp": SPDX,
    "host/geometry/pose.hpp": SPDX + '#include "host/base/ids.hpp"\n',
    "host/geometry/pose.cpp": SPDX + '#include "host/geometry/pose.hpp"\n#include "gpu/detector.hpp"\n',
    "host/geometry/CMakeLists.txt": "# SPDX-License-Identifier: MIT\n"
                                    "glint_module(glint_geometry SOURCES pose.cpp\n"
                                    "  DEPENDS glint_base glint_gpu Eigen3::Eigen)\n",
    "host/apps/version.hpp.in": "",
    "host/apps/main.cpp": SPDX + '#include <CLI/CLI.hpp>\n#include "gpu/detector.hpp"\n#include "host/apps/version.hpp"\n',
    "tests/unit/pose_test.cpp": SPDX + '#include <gtest/gtest.h>\n#include "host/geometry/pose.hpp"\n',
    "build/dev/junk.cpp": "no rules here\n",
}


class LayersTest(unittest.TestCase):
    def findings(self, **changes):
        return self.findings_of(changes)

    def findings_of(self, changes, table=None):
        with tempfile.TemporaryDirectory() as root:
            for path, text in {**GOOD, **changes}.items():
                full = os.path.join(root, path)
                os.makedirs(os.path.dirname(full), exist_ok=True)
                with open(full, "w", encoding="utf-8") as file:
                    file.write(text)
            return check_layers.check(root, table)

    def expect_one(self, path, line, text, content):
        found = self.findings_of({path: content})
        self.assertEqual([(f, n) for f, n, _ in found], [(path, line)], found)
        self.assertIn(text, found[0][2])

    def test_a_good_tree_has_no_findings(self):
        self.assertEqual(self.findings_of({}), [])

    def test_forbidden_includes(self):
        for path, target, text in [
            ("gpu/a.hpp", "host/base/ids.hpp", "gpu may not include host/base"),
            ("host/base/a.hpp", "gpu/detector.hpp", "host/base may not include gpu"),
            ("host/frames/a.hpp", "host/geometry/pose.hpp", "host/frames may not include host/geometry"),
            ("host/geometry/a.hpp", "shaders/interface/blob.h", "host/geometry may not include shaders/interface"),
            ("host/geometry/a.hpp", "tests/unit/pose_test.cpp", "nothing but tests may include tests"),
            ("host/apps/a.hpp", "tests/unit/pose_test.cpp", "nothing but tests may include tests"),
            ("host/geometry/a.hpp", "host/apps/main.cpp", "host/geometry may not include host/apps"),
            ("host/geometry/a.hpp", "host/geometry/none.hpp", "no such file"),
            ("host/geometry/a.hpp", "pose.hpp", "includes are paths in the repository"),
            ("shaders/b.comp", "host/base/ids.hpp", "shaders may not include"),
        ]:
            with self.subTest(path=path, target=target):
                self.expect_one(path, 3, text, SPDX + f'// what\n#include "{target}"\n')

    def test_reserved_libraries(self):
        for path, target, text in [
            ("gpu/a.cpp", "vulkan/vulkan.h", "Vulkan may be included only in gpu/vulkan"),
            ("host/apps/a.cpp", "vulkan/vulkan.hpp", "Vulkan"),
            ("host/apps/a.cpp", "toml++/toml.h", "toml++ may be included only in host/config"),
            ("host/sim/a.cpp", "libavcodec/avcodec.h", "FFmpeg may be included only in host/capture"),
            ("host/capture/a.cpp", "opencv2/core.hpp", "OpenCV may be included only in benchmarks"),
            ("tests/unit/a_test.cpp", "opencv2/core.hpp", "OpenCV"),
            ("host/config/a.cpp", "CLI/CLI.hpp", "CLI11 may be included only in host/apps"),
            ("host/track/a.cpp", "gtest/gtest.h", "GoogleTest may be included only in tests"),
        ]:
            with self.subTest(path=path, target=target):
                self.expect_one(path, 2, text, SPDX + f"#include <{target}>\n")

    def test_interface_includes_only_cstdint(self):
        self.expect_one("shaders/interface/a.h", 2, "<cstdint> only", SPDX + "#include <vector>\n")
        self.expect_one("shaders/interface/a.h", 2, "only", SPDX + '#include "shaders/interface/blob.h"\n')

    def test_own_header_first(self):
        self.expect_one("host/geometry/pose.cpp", 2, 'must be "host/geometry/pose.hpp"',
                        SPDX + '#include <vector>\n#include "host/geometry/pose.hpp"\n')

    def test_length(self):
        self.expect_one("host/geometry/long.hpp", 601, "601 lines", SPDX + "\n" * 600)
        self.assertEqual(self.findings_of({"host/geometry/long.hpp": SPDX + "\n" * 599}), [])

    def test_licence(self):
        self.expect_one("host/geometry/a.hpp", 1, "licence", "// no licence\n")
        self.expect_one("tests/run.sh", 1, "licence", "#!/bin/sh\necho\n")

    def test_vague_names(self):
        for path in ["host/geometry/math_utils.hpp", "host/common/a.hpp", "tests/support/test-helper.py"]:
            with self.subTest(path=path):
                found = self.findings_of({path: "# SPDX-License-Identifier: MIT\n"})
                self.assertEqual([f for f, _, _ in found], [path])
        self.expect_one("host/geometry/a.hpp", 2, "CameraManager", SPDX + "class CameraManager {\n")
        self.assertEqual(self.findings_of({"host/geometry/futile.hpp": SPDX}), [])

    def test_cmake_depends_equal_the_row(self):
        head = "# SPDX-License-Identifier: MIT\n\n"
        path = "host/geometry/CMakeLists.txt"
        self.expect_one(path, 3, "DEPENDS lacks glint_gpu", head + "glint_module(glint_geometry DEPENDS glint_base)\n")
        self.expect_one(path, 3, "may not depend on glint_track",
                        head + "glint_module(glint_geometry DEPENDS glint_base glint_gpu glint_track)\n")
        self.expect_one(path, 3, "may not depend on glint_sim",
                        head + "glint_module(glint_geometry DEPENDS glint_base glint_gpu PRIVATE glint_sim)\n")
        self.expect_one(path, 3, "named glint_geometry",
                        head + "glint_module(glint_geo DEPENDS glint_base glint_gpu)\n")

    def test_cycles_in_the_table(self):
        self.assertEqual(check_layers.cycle_in(check_layers.TABLE), [])
        self.assertEqual(check_layers.cycle_in({"a": ["b"], "b": ["c"], "c": ["b"]}), ["b", "c", "b"])
        found = self.findings_of({}, {"a": ["a"]})
        self.assertEqual(len(found), 1)
        self.assertIn("cycle: a -> a", found[0][2])


if __name__ == "__main__":
    unittest.main()
