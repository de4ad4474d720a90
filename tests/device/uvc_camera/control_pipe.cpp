// SPDX-License-Identifier: MIT
// Requests by type and number (USB 2.0, 9.4; UVC 1.0, chapter 4).
#include "tests/device/uvc_camera/control_pipe.hpp"

#include <algorithm>
#include <cstdlib>

namespace glint::device {
namespace {

enum : unsigned {
  kGetStatus = 0,
  kClearFeature = 1,
  kGetDescriptor = 6,
  kGetConfiguration = 8,
  kSetConfiguration = 9,
  kGetInterface = 10,
  kSetInterface = 11
};
enum : unsigned {
  kSetCur = 0x01,
  kGetCur = 0x81,
  kGetMin = 0x82,
  kGetMax = 0x83,
  kGetRes = 0x84,
  kGetLen = 0x85,
  kGetInfo = 0x86,
  kGetDef = 0x87
};
using Bytes = std::vector<std::uint8_t>;

enum : unsigned { kProbe = 1, kCommit = 2 };
constexpr unsigned kTypeMask = 0x60, kClassRequest = 0x20, kInterfaceMask = 0x1F, kToInterface = 1;
constexpr std::size_t kProbeBytes = 26, kIntervalAt = 4;

std::vector<std::uint8_t> little_endian(std::uint32_t value, unsigned bytes) {
  std::vector<std::uint8_t> out;
  for (unsigned i = 0; i < bytes; ++i) out.push_back(static_cast<std::uint8_t>(value >> 8 * i));
  return out;
}

std::uint32_t little_endian(std::span<const std::uint8_t> bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = std::min<std::size_t>(bytes.size(), 4); i-- > 0;) value = value << 8 | bytes[i];
  return value;
}

}  // namespace

ControlPipe::ControlPipe(CameraModel model) : model_(std::move(model)) {
  probed_interval_ = committed_interval_ = interval_100ns(model_.rates_hz.front());
  // Of the automatic-exposure mode, a set of bits, `step` says which there are: 1 manual, 8 by the camera.
  controls_[{kCameraTerminal, 2}] = {1, 1, 8, 9, 8, 8};
  controls_[{kCameraTerminal, 3}] = {1, 0, 1, 1, 0, 0};  // frame rate may drop; trigger mode on such cameras
  controls_[{kCameraTerminal, 4}] = {4, 1, 5000, 1, 157, 157};  // exposure time, 100 us
  controls_[{kProcessingUnit, 2}] = {2, 0, 64, 1, 0, 0};        // brightness
  controls_[{kProcessingUnit, 4}] = {2, 0, 100, 1, 0, 0};       // gain
}

std::optional<std::uint32_t> ControlPipe::value(std::uint8_t entity, std::uint8_t selector) const {
  const auto found = controls_.find({entity, selector});
  if (found == controls_.end()) return std::nullopt;
  return found->second.value;
}

std::optional<std::vector<std::uint8_t>> ControlPipe::answer(const std::array<std::uint8_t, 8>& setup,
                                                             std::span<const std::uint8_t> data) {
  const unsigned type = setup[0], request = setup[1];
  const unsigned value = setup[2] | setup[3] * 256u, index = setup[4] | setup[5] * 256u;
  const std::size_t length = setup[6] | setup[7] * 256u;
  Answer reply;
  if ((type & kTypeMask) == 0) {
    reply = standard(request, value, index);
  } else if ((type & kTypeMask) == kClassRequest && (type & kInterfaceMask) == kToInterface) {
    const unsigned interface = index & 255u, entity = index >> 8;
    if (interface == kStreamInterface) reply = negotiate(request, value >> 8, data);
    if (interface == kControlInterface) reply = control(request, entity, value >> 8, data);
  }
  if (reply && reply->size() > length) reply->resize(length);
  return reply;
}

ControlPipe::Answer ControlPipe::standard(unsigned request, unsigned value, unsigned index) {
  const auto known = [](std::vector<std::uint8_t> bytes) {
    return bytes.empty() ? Answer() : Answer(std::move(bytes));
  };
  switch (request) {
    case kGetDescriptor:
      if (value >> 8 == 1) return device_descriptor(model_);
      if (value >> 8 == 2) return configuration_descriptor(model_);
      if (value >> 8 == 3) return known(string_descriptor(model_, value & 255u));
      return std::nullopt;
    case kGetStatus:
      return Bytes{0, 0};
    case kClearFeature:
      return Bytes();
    case kGetConfiguration:
      return Bytes{static_cast<std::uint8_t>(configuration_)};
    case kSetConfiguration:
      configuration_ = value;
      alternate_ = 0;
      return Bytes();
    case kGetInterface:
      return Bytes{static_cast<std::uint8_t>(index == kStreamInterface ? alternate_ : 0)};
    case kSetInterface:
      if (index == kStreamInterface && value > std::size(kAlternateBytes)) return std::nullopt;
      if (index == kStreamInterface) alternate_ = value;
      return Bytes();
    default:
      return std::nullopt;
  }
}

std::vector<std::uint8_t> ControlPipe::offer(std::uint32_t interval) const {
  std::vector<std::uint8_t> bytes(kProbeBytes);
  bytes[2] = bytes[3] = 1;  // the only format and its only size
  const auto put = [&](std::size_t at, std::uint32_t word) {
    const std::vector<std::uint8_t> four = little_endian(word, 4);
    std::copy(four.begin(), four.end(), bytes.begin() + static_cast<std::ptrdiff_t>(at));
  };
  put(kIntervalAt, interval);
  put(18, most_frame_bytes(model_));
  put(22, kAlternateBytes[std::size(kAlternateBytes) - 1]);
  return bytes;
}

ControlPipe::Answer ControlPipe::negotiate(unsigned request, unsigned selector,
                                           std::span<const std::uint8_t> data) {
  if (selector != kProbe && selector != kCommit) return std::nullopt;
  std::uint32_t& interval = selector == kProbe ? probed_interval_ : committed_interval_;
  const auto [fastest, slowest] = std::minmax_element(model_.rates_hz.begin(), model_.rates_hz.end());
  switch (request) {
    case kSetCur: {
      if (data.size() < kIntervalAt + 4) return std::nullopt;
      const std::uint32_t wanted = little_endian(data.subspan(kIntervalAt, 4));
      const auto off_by = [&](std::uint32_t rate_hz) {
        return std::abs(static_cast<std::int64_t>(interval_100ns(rate_hz)) -
                        static_cast<std::int64_t>(wanted));
      };
      interval = interval_100ns(*std::min_element(model_.rates_hz.begin(), model_.rates_hz.end(),
                                                  [&](auto a, auto b) { return off_by(a) < off_by(b); }));
      return Bytes();
    }
    case kGetCur:
      return offer(interval);
    case kGetMin:
      return offer(interval_100ns(*slowest));
    case kGetMax:
      return offer(interval_100ns(*fastest));
    case kGetDef:
      return offer(interval_100ns(model_.rates_hz.front()));
    case kGetLen:
      return Bytes{static_cast<std::uint8_t>(kProbeBytes), 0};
    case kGetInfo:
      return Bytes{3};
    default:
      return std::nullopt;
  }
}

ControlPipe::Answer ControlPipe::control(unsigned request, unsigned entity, unsigned selector,
                                         std::span<const std::uint8_t> data) {
  const auto found = controls_.find({entity, selector});
  if (found == controls_.end()) return std::nullopt;
  CameraControl& c = found->second;
  switch (request) {
    case kSetCur: {
      const std::uint32_t wanted = little_endian(data);
      if (data.size() < c.bytes || wanted < c.low || wanted > c.high) return std::nullopt;
      c.value = wanted;
      return Bytes();
    }
    case kGetCur:
      return little_endian(c.value, c.bytes);
    case kGetMin:
      return little_endian(c.low, c.bytes);
    case kGetMax:
      return little_endian(c.high, c.bytes);
    case kGetRes:
      return little_endian(c.step, c.bytes);
    case kGetDef:
      return little_endian(c.initial, c.bytes);
    case kGetLen:
      return little_endian(c.bytes, 2);
    case kGetInfo:
      return Bytes{3};
    default:
      return std::nullopt;
  }
}

}  // namespace glint::device
