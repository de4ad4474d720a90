// SPDX-License-Identifier: MIT
// Built from the inside out, so that lengths are counted and not written down.
#include "tests/device/uvc_camera/descriptors.hpp"

#include <initializer_list>

namespace glint::device {
namespace {

enum : std::uint8_t {
  kDevice = 1,
  kConfiguration = 2,
  kString = 3,
  kInterface = 4,
  kEndpoint = 5,
  kAssociation = 11,
  kClassInterface = 0x24
};
enum : std::uint8_t { kVideoClass = 14, kVideoControl = 1, kVideoStreaming = 2, kVideoCollection = 3 };

/// One descriptor: the length stands in front when it is done.
class Descriptor {
 public:
  Descriptor& u8(std::initializer_list<unsigned> values) {
    for (const unsigned value : values) bytes_.push_back(static_cast<std::uint8_t>(value));
    return *this;
  }
  Descriptor& u16(unsigned value) { return u8({value & 255u, value >> 8 & 255u}); }
  Descriptor& u32(std::uint32_t value) { return u16(value & 0xFFFFu).u16(value >> 16); }
  std::vector<std::uint8_t> done() {
    bytes_[0] = static_cast<std::uint8_t>(bytes_.size());
    return bytes_;
  }

 private:
  std::vector<std::uint8_t> bytes_{0};
};

using Bytes = std::vector<std::uint8_t>;

void append(Bytes& to, const Bytes& more) { to.insert(to.end(), more.begin(), more.end()); }

Bytes interface(unsigned number, unsigned alternate, unsigned endpoints, unsigned subclass) {
  return Descriptor().u8({kInterface, number, alternate, endpoints, kVideoClass, subclass, 0, 0}).done();
}

/// A header that counts the bytes of itself and of what follows it, in two bytes at `at`.
void set_total(Bytes& bytes, std::size_t at, std::size_t total) {
  bytes[at] = static_cast<std::uint8_t>(total);
  bytes[at + 1] = static_cast<std::uint8_t>(total >> 8);
}

Bytes control_part() {
  constexpr unsigned kAutoExposure = 1u << 1, kFrameRateMayDrop = 1u << 2, kExposureTime = 1u << 3;
  constexpr unsigned kBrightness = 1u << 0, kGain = 1u << 9;
  constexpr unsigned kCamera = 0x0201, kToUsb = 0x0101;
  Bytes entities = Descriptor()
                       .u8({kClassInterface, 2, kCameraTerminal})
                       .u16(kCamera)
                       .u8({0, 0})
                       .u16(0)
                       .u16(0)
                       .u16(0)
                       .u8({3, kAutoExposure | kFrameRateMayDrop | kExposureTime, 0, 0})
                       .done();
  append(entities, Descriptor()
                       .u8({kClassInterface, 5, kProcessingUnit, kCameraTerminal})
                       .u16(0)
                       .u8({2})
                       .u16(kBrightness | kGain)
                       .u8({0})
                       .done());
  append(
      entities,
      Descriptor().u8({kClassInterface, 3, kOutputTerminal}).u16(kToUsb).u8({0, kProcessingUnit, 0}).done());
  Bytes header = Descriptor()
                     .u8({kClassInterface, 1})
                     .u16(0x0100)
                     .u16(0)
                     .u32(48'000'000)
                     .u8({1, kStreamInterface})
                     .done();
  set_total(header, 5, header.size() + entities.size());
  Bytes part = interface(kControlInterface, 0, 0, kVideoControl);
  append(part, header);
  append(part, entities);
  return part;
}

Bytes stream_part(const CameraModel& model) {
  Bytes formats = Descriptor().u8({kClassInterface, 6, 1, 1, 1, 1, 0, 0, 0, 0}).done();
  Descriptor frame;
  frame.u8({kClassInterface, 7, 1, 0}).u16(model.width_px).u16(model.height_px);
  const std::uint32_t frame_bits = most_frame_bytes(model) * 8;
  frame.u32(frame_bits * 30).u32(frame_bits * 120).u32(most_frame_bytes(model));
  frame.u32(interval_100ns(model.rates_hz.front())).u8({static_cast<unsigned>(model.rates_hz.size())});
  for (const std::uint32_t rate_hz : model.rates_hz) frame.u32(interval_100ns(rate_hz));
  append(formats, frame.done());
  append(formats, Descriptor().u8({kClassInterface, 13, 1, 1, 4}).done());
  Bytes header = Descriptor()
                     .u8({kClassInterface, 1, 1})
                     .u16(0)
                     .u8({kStreamEndpoint, 0, kOutputTerminal, 0, 0, 0, 1, 0})
                     .done();
  set_total(header, 4, header.size() + formats.size());
  Bytes part = interface(kStreamInterface, 0, 0, kVideoStreaming);
  append(part, header);
  append(part, formats);
  unsigned alternate = 0;
  for (const std::uint32_t bytes : kAlternateBytes) {
    append(part, interface(kStreamInterface, ++alternate, 1, kVideoStreaming));
    constexpr unsigned kIsochronousAsync = 5, kMostPerTransaction = 1024;
    const unsigned more_transactions = (bytes - 1) / kMostPerTransaction;
    append(part, Descriptor()
                     .u8({kEndpoint, kStreamEndpoint, kIsochronousAsync})
                     .u16(bytes / (more_transactions + 1) | more_transactions << 11)
                     .u8({1})
                     .done());
  }
  return part;
}

}  // namespace

std::vector<std::uint8_t> device_descriptor(const CameraModel& model) {
  constexpr unsigned kMiscellaneous = 0xEF, kWithAssociations = 2;
  return Descriptor()
      .u8({kDevice})
      .u16(0x0200)
      .u8({kMiscellaneous, kWithAssociations, 1, 64})
      .u16(model.vendor)
      .u16(model.product)
      .u16(0x0100)
      .u8({1, 2, 3, 1})
      .done();
}

std::vector<std::uint8_t> configuration_descriptor(const CameraModel& model) {
  constexpr unsigned kBusPowered = 0x80, k500mA = 250;
  Bytes bytes = Descriptor().u8({kConfiguration}).u16(0).u8({2, 1, 0, kBusPowered, k500mA}).done();
  append(bytes,
         Descriptor().u8({kAssociation, kControlInterface, 2, kVideoClass, kVideoCollection, 0, 0}).done());
  append(bytes, control_part());
  append(bytes, stream_part(model));
  set_total(bytes, 2, bytes.size());
  return bytes;
}

std::vector<std::uint8_t> string_descriptor(const CameraModel& model, unsigned number) {
  constexpr unsigned kEnglish = 0x0409;
  if (number == 0) return Descriptor().u8({kString}).u16(kEnglish).done();
  if (number > 3) return {};
  const std::string& text = number == 1 ? model.maker : number == 2 ? model.name : model.serial;
  Descriptor descriptor;
  descriptor.u8({kString});
  for (const char letter : text) descriptor.u16(static_cast<unsigned char>(letter));
  return descriptor.done();
}

}  // namespace glint::device
