// SPDX-License-Identifier: MIT
// Endpoint 0 of the camera: standard requests, format negotiation, exposure and gain.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "tests/device/uvc_camera/descriptors.hpp"

namespace glint::device {

/// What the host may set: its limits and its value, little-endian on the wire.
struct CameraControl {
  unsigned bytes = 0;
  std::uint32_t low = 0, high = 0, step = 0, initial = 0, value = 0;
};

class ControlPipe {
 public:
  explicit ControlPipe(CameraModel model);

  /// The answer to a request: the bytes of an IN request, nothing for an OUT request that was obeyed; no
  /// value: the request is refused (STALL).
  std::optional<std::vector<std::uint8_t>> answer(const std::array<std::uint8_t, 8>& setup,
                                                  std::span<const std::uint8_t> data);

  /// Alternate setting of the stream; 0: not streaming.
  unsigned alternate() const noexcept { return alternate_; }
  /// Value of a control by entity and selector, for tests and the log; nothing if there is none.
  std::optional<std::uint32_t> value(std::uint8_t entity, std::uint8_t selector) const;

 private:
  using Answer = std::optional<std::vector<std::uint8_t>>;
  Answer standard(unsigned request, unsigned value, unsigned index);
  Answer negotiate(unsigned request, unsigned selector, std::span<const std::uint8_t> data);
  Answer control(unsigned request, unsigned entity, unsigned selector, std::span<const std::uint8_t> data);
  std::vector<std::uint8_t> offer(std::uint32_t interval_100ns) const;

  CameraModel model_;
  unsigned configuration_ = 0, alternate_ = 0;
  std::uint32_t probed_interval_ = 0, committed_interval_ = 0;
  std::map<std::pair<unsigned, unsigned>, CameraControl> controls_;  // by entity and selector
};

}  // namespace glint::device
