// SPDX-License-Identifier: MIT
// The camera's descriptors, read as a host reads them.
#include "tests/device/uvc_camera/descriptors.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace glint::device {
namespace {

using Bytes = std::vector<std::uint8_t>;

unsigned word(const Bytes& bytes, std::size_t at) { return bytes[at] | bytes[at + 1] * 256u; }

/// The configuration cut into its descriptors by their lengths.
std::vector<Bytes> cut(const Bytes& all) {
  std::vector<Bytes> parts;
  for (std::size_t at = 0; at < all.size(); at += parts.back().size()) {
    EXPECT_GE(all[at], 2) << "a descriptor at " << at << " has no length";
    if (all[at] < 2 || at + all[at] > all.size()) return parts;
    parts.emplace_back(all.begin() + static_cast<std::ptrdiff_t>(at),
                       all.begin() + static_cast<std::ptrdiff_t>(at + all[at]));
  }
  return parts;
}

/// Descriptors of that type, and of that subtype where it is class-specific.
std::vector<Bytes> of(const std::vector<Bytes>& parts, unsigned type, unsigned subtype = 0) {
  std::vector<Bytes> found;
  for (const Bytes& part : parts) {
    if (part[1] == type && (subtype == 0 || part[2] == subtype)) found.push_back(part);
  }
  return found;
}

/// Class-specific descriptors before (`control`) or after the stream's first interface.
std::vector<Bytes> class_part(const std::vector<Bytes>& parts, bool control) {
  std::vector<Bytes> found;
  unsigned interface = 0;
  for (const Bytes& part : parts) {
    if (part[1] == 4) interface = part[2];
    if (part[1] == 0x24 && (interface == kControlInterface) == control) found.push_back(part);
  }
  return found;
}

TEST(Descriptors, LengthsAndTotalsAreRight) {
  const Bytes all = configuration_descriptor({});
  const std::vector<Bytes> parts = cut(all);
  ASSERT_FALSE(parts.empty());
  EXPECT_EQ(parts[0][1], 2);
  EXPECT_EQ(word(parts[0], 2), all.size());
  const auto bytes_of = [](const std::vector<Bytes>& list) {
    std::size_t sum = 0;
    for (const Bytes& part : list) sum += part.size();
    return sum;
  };
  const std::vector<Bytes> control = class_part(parts, true), stream = class_part(parts, false);
  ASSERT_FALSE(control.empty());
  ASSERT_FALSE(stream.empty());
  EXPECT_EQ(word(control[0], 5), bytes_of(control));
  EXPECT_EQ(word(stream[0], 4), bytes_of(stream));
}

TEST(Descriptors, DeviceHasEighteenBytesAndASerialNumber) {
  const CameraModel model;
  const Bytes device = device_descriptor(model);
  ASSERT_EQ(device.size(), 18u);
  EXPECT_EQ(device[0], 18);
  EXPECT_EQ(word(device, 8), model.vendor);
  EXPECT_EQ(word(device, 10), model.product);
  const Bytes serial = string_descriptor(model, device[16]);
  ASSERT_EQ(serial.size(), 2 + 2 * model.serial.size());
  EXPECT_EQ(serial[2], model.serial[0]);
  EXPECT_TRUE(string_descriptor(model, 4).empty());
}

TEST(Descriptors, FrameHasSizeAndAllRates) {
  CameraModel model;
  model.rates_hz = {90, 30};
  const std::vector<Bytes> frames = of(class_part(cut(configuration_descriptor(model)), false), 0x24, 7);
  ASSERT_EQ(frames.size(), 1u);
  const Bytes& frame = frames[0];
  EXPECT_EQ(frame.size(), 26u + 4 * 2);
  EXPECT_EQ(word(frame, 5), model.width_px);
  EXPECT_EQ(word(frame, 7), model.height_px);
  EXPECT_EQ(frame[25], 2);
  EXPECT_EQ(word(frame, 26) | word(frame, 28) << 16, 10'000'000u / 90);
  EXPECT_EQ(word(frame, 30) | word(frame, 32) << 16, 10'000'000u / 30);
}

TEST(Descriptors, EntitiesAreChainedFromSensorToUsb) {
  const std::vector<Bytes> control = class_part(cut(configuration_descriptor({})), true);
  const Bytes camera = of(control, 0x24, 2).at(0), unit = of(control, 0x24, 5).at(0),
              output = of(control, 0x24, 3).at(0);
  EXPECT_EQ(camera.size(), 18u);
  EXPECT_EQ(unit.size(), 9u + 2);
  EXPECT_EQ(output.size(), 9u);
  EXPECT_EQ(unit[4], camera[3]);
  EXPECT_EQ(output[7], unit[3]);
}

TEST(Descriptors, AlternateSettingsGrowInBandwidth) {
  const std::vector<Bytes> endpoints = of(cut(configuration_descriptor({})), 5);
  ASSERT_EQ(endpoints.size(), std::size(kAlternateBytes));
  for (std::size_t i = 0; i < endpoints.size(); ++i) {
    const unsigned packet = word(endpoints[i], 4);
    EXPECT_EQ((packet & 0x7FFu) * (1 + (packet >> 11 & 3u)), kAlternateBytes[i]);
    EXPECT_EQ(endpoints[i][3] & 3, 1) << "not isochronous";
  }
}

}  // namespace
}  // namespace glint::device
