// SPDX-License-Identifier: MIT
// What endpoint 0 answers.
#include "tests/device/uvc_camera/control_pipe.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace glint::device {
namespace {

using Bytes = std::vector<std::uint8_t>;
using ::testing::ElementsAre;
using ::testing::Optional;

std::array<std::uint8_t, 8> setup(unsigned type, unsigned request, unsigned value, unsigned index,
                                  unsigned length) {
  const auto low = [](unsigned v) { return static_cast<std::uint8_t>(v); };
  return {low(type),  low(request),    low(value),  low(value >> 8),
          low(index), low(index >> 8), low(length), low(length >> 8)};
}

TEST(ControlPipe, CutsDescriptorsToTheLengthAskedFor) {
  ControlPipe pipe({});
  const auto answer = pipe.answer(setup(0x80, 6, 0x0200, 0, 9), {});
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->size(), 9u);
}

TEST(ControlPipe, RefusesWhatItDoesNotKnow) {
  ControlPipe pipe({});
  EXPECT_FALSE(pipe.answer(setup(0x80, 6, 0x0600, 0, 10), {}));                       // device qualifier
  EXPECT_FALSE(pipe.answer(setup(0xA1, 0x81, 0x0900, kCameraTerminal << 8, 2), {}));  // no such control
  EXPECT_FALSE(pipe.answer(setup(0x01, 11, 9, kStreamInterface, 0), {}));             // no such setting
}

TEST(ControlPipe, NegotiatesTheNearestRate) {
  ControlPipe pipe({});
  Bytes probe(26);
  const std::uint32_t wanted = 10'000'000u / 88;
  for (unsigned i = 0; i < 4; ++i) probe[4 + i] = static_cast<std::uint8_t>(wanted >> 8 * i);
  ASSERT_TRUE(pipe.answer(setup(0x21, 0x01, 0x0100, kStreamInterface, 26), probe));
  const auto got = pipe.answer(setup(0xA1, 0x81, 0x0100, kStreamInterface, 26), {});
  ASSERT_TRUE(got);
  ASSERT_EQ(got->size(), 26u);
  EXPECT_EQ((*got)[4] | (*got)[5] << 8 | (*got)[6] << 16, 10'000'000 / 90);
}

TEST(ControlPipe, KeepsControlsWithinTheirLimits) {
  ControlPipe pipe({});
  const unsigned gain = kProcessingUnit << 8;
  EXPECT_TRUE(pipe.answer(setup(0x21, 0x01, 0x0400, gain, 2), Bytes{42, 0}));
  EXPECT_THAT(pipe.answer(setup(0xA1, 0x81, 0x0400, gain, 2), {}), Optional(ElementsAre(42, 0)));
  EXPECT_FALSE(pipe.answer(setup(0x21, 0x01, 0x0400, gain, 2), Bytes{101, 0}));
  EXPECT_THAT(pipe.value(kProcessingUnit, 4), Optional(42u));
}

TEST(ControlPipe, StreamsBetweenAlternateSettings) {
  ControlPipe pipe({});
  EXPECT_EQ(pipe.alternate(), 0u);
  EXPECT_TRUE(pipe.answer(setup(0x01, 11, 3, kStreamInterface, 0), {}));
  EXPECT_EQ(pipe.alternate(), 3u);
  EXPECT_TRUE(pipe.answer(setup(0x01, 11, 0, kStreamInterface, 0), {}));
  EXPECT_EQ(pipe.alternate(), 0u);
}

}  // namespace
}  // namespace glint::device
