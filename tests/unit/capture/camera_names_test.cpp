// SPDX-License-Identifier: MIT
// Natural order, and which camera of a source is which of the rig.
#include "host/capture/camera_names.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/unit/capture/av_fixture.hpp"

namespace glint {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(NaturalOrder, NumbersCountAsNumbers) {
  std::vector<std::string> names{"cam10", "cam2", "cam1", "cam02b", "a", "cam", "b1"};
  std::sort(names.begin(), names.end(), natural_less);
  EXPECT_THAT(names, ElementsAre("a", "b1", "cam", "cam1", "cam2", "cam02b", "cam10"));
}

TEST(NaturalOrder, IsAStrictOrder) {
  const std::vector<std::string> names{"",   "0",   "00", "1",   "01",   "10",
                                       "a0", "a00", "a",  "a1b", "a01b", "a1a"};
  for (const auto& a : names) {
    EXPECT_FALSE(natural_less(a, a)) << a;
    for (const auto& b : names) {
      if (a != b) {
        EXPECT_NE(natural_less(a, b), natural_less(b, a)) << a << " " << b;
      }
      for (const auto& c : names) {
        if (natural_less(a, b) && natural_less(b, c)) {
          EXPECT_TRUE(natural_less(a, c)) << a << " " << b << " " << c;
        }
      }
    }
  }
}

TEST(SelectCameras, TakesTheRigsOrderAndLeavesOthersOut) {
  EXPECT_THAT(select_cameras({"a", "b", "c"}, {"c", "a"}, "here"), ElementsAre(2, 0));
  EXPECT_THAT(select_cameras({"a", "b"}, {}, "here"), ElementsAre(0, 1));
}

TEST(SelectCameras, AnUnknownNameListsBothSides) {
  const std::string text = test::error_of([] { select_cameras({"a", "b"}, {"a", "north"}, "/rec"); });
  EXPECT_THAT(text, HasSubstr("/rec"));
  EXPECT_THAT(text, HasSubstr("the rig wants a, north"));
  EXPECT_THAT(text, HasSubstr("the source has a, b"));
  EXPECT_THAT(text, HasSubstr("not found: north"));
}

TEST(SelectCameras, RefusesDoublesNoneAndTooMany) {
  EXPECT_THAT(test::error_of([] {
                select_cameras({"a", "a"}, {}, "/rec");
              }),
              HasSubstr("\"a\" occurs twice"));
  EXPECT_THAT(test::error_of([] { select_cameras({"a"}, {"a", "a"}, "/rec"); }), HasSubstr("the rig"));
  EXPECT_THAT(test::error_of([] { select_cameras({}, {}, "/rec"); }), HasSubstr("no cameras"));
  std::vector<std::string> many;
  for (int n = 0; n < 33; ++n) many.push_back(std::to_string(n));
  EXPECT_THAT(test::error_of([&] { select_cameras(many, {}, "/rec"); }), HasSubstr("33 cameras"));
}

}  // namespace
}  // namespace glint
