// SPDX-License-Identifier: MIT
// Fault scripts, good and bad.
#include "tests/device/uvc_camera/fault_script.hpp"

#include <gtest/gtest.h>

#include <sstream>

#include "host/base/error.hpp"

namespace glint::device {
namespace {

FaultScript script(const std::string& text) {
  std::istringstream lines(text);
  return FaultScript(lines, "faults.txt", 4);
}

TEST(FaultScript, ReadsLinesCommentsAndStars) {
  const FaultScript faults = script("# nothing\n\n10 2 never\n10 2 late:7.5  # more\n20 * dark\n");
  ASSERT_EQ(faults.at(10, 1).size(), 2u);
  EXPECT_EQ(faults.at(10, 1)[0].kind, FaultKind::Never);
  EXPECT_EQ(faults.at(10, 1)[1].kind, FaultKind::Late);
  EXPECT_DOUBLE_EQ(faults.at(10, 1)[1].amount, 7.5);
  EXPECT_TRUE(faults.at(10, 0).empty());
  for (unsigned c = 0; c < 4; ++c) EXPECT_EQ(faults.at(20, c).size(), 1u) << c;
}

TEST(FaultScript, NamesTheLineThatIsWrong) {
  for (const char* line : {"x 1 never", "1 0 never", "1 5 never", "1 1", "1 1 nothing", "1 1 late",
                           "1 1 never:3", "1 1 late:x", "1 1 late:-1", "1 1 never again"}) {
    try {
      script(std::string("1 1 never\n") + line + "\n");
      ADD_FAILURE() << "accepted: " << line;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("faults.txt:2: "), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace glint::device
