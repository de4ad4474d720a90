// SPDX-License-Identifier: MIT
#include "host/match/usual_brightness.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

namespace glint {
namespace {

TEST(UsualBrightness, IsUnknownUntilEnoughMarkersWereSeen) {
  UsualBrightness usual;
  EXPECT_EQ(usual.grey(2.0), 0.0);
  for (int k = 0; k < 29; ++k) usual.learn(100.0, 2.0);
  EXPECT_EQ(usual.grey(2.0), 0.0);
  usual.learn(100.0, 2.0);
  EXPECT_NEAR(usual.grey(2.0), 100.0, 2.0);
  EXPECT_EQ(usual.grey(0.0), 0.0);
}

class UsualBrightnessByPower : public ::testing::TestWithParam<double> {};

TEST_P(UsualBrightnessByPower, FindsHowItGoesWithTheSizeThoughSomeAreHidden) {
  constexpr std::array kRadii_px{1.0, 3.5, 1.4, 2.0, 2.7};
  const auto truth = [](double radius_px) { return 40.0 * std::pow(radius_px, GetParam()); };
  UsualBrightness usual;
  for (std::size_t k = 0; k < 3000; ++k) {
    const double radius_px = kRadii_px[k % kRadii_px.size()];
    usual.learn(truth(radius_px) * (k % 11 == 0 ? 0.2 : 1.0), radius_px);
  }
  for (const double radius_px : kRadii_px)
    EXPECT_NEAR(usual.grey(radius_px) / truth(radius_px), 1.0, 0.03) << radius_px << " px";
}

INSTANTIATE_TEST_SUITE_P(LargeLampsAndSmall, UsualBrightnessByPower, ::testing::Values(0.0, 1.0, 2.0));

TEST(UsualBrightness, NonsenseTeachesNothing) {
  UsualBrightness usual;
  for (int k = 0; k < 100; ++k) usual.learn(0.0, 2.0), usual.learn(100.0, 0.0);
  EXPECT_EQ(usual.grey(2.0), 0.0);
}

}  // namespace
}  // namespace glint
