// SPDX-License-Identifier: MIT
// What a UVC 1.0 camera with one MJPEG size says of itself (USB 2.0 chapter 9; UVC 1.0 chapter 3).
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace glint::device {

struct CameraModel {
  std::uint16_t vendor = 0x0c45, product = 0x6366;
  std::string maker = "glint tests", name = "Virtual OV9281", serial = "GLINT0001";
  std::uint32_t width_px = 1280, height_px = 800;
  std::vector<std::uint32_t> rates_hz{120, 100, 90, 60, 30};  ///< the first is the default
};

/// Interfaces, entities and the endpoint, as the descriptors number them.
inline constexpr std::uint8_t kControlInterface = 0, kStreamInterface = 1;
inline constexpr std::uint8_t kCameraTerminal = 1, kProcessingUnit = 2, kOutputTerminal = 3;
inline constexpr std::uint8_t kStreamEndpoint = 0x81;
/// Bytes per microframe of the stream's alternate settings 1, 2, ...
inline constexpr std::uint32_t kAlternateBytes[] = {1024, 2048, 3072};

/// What a frame rate is called in requests: in units of 100 ns.
constexpr std::uint32_t interval_100ns(std::uint32_t rate_hz) noexcept { return 10'000'000u / rate_hz; }
/// Room that the host must have for one frame.
constexpr std::uint32_t most_frame_bytes(const CameraModel& model) noexcept {
  return model.width_px * model.height_px;
}

std::vector<std::uint8_t> device_descriptor(const CameraModel& model);
std::vector<std::uint8_t> configuration_descriptor(const CameraModel& model);
/// Empty where there is no such string. 0 is the list of languages.
std::vector<std::uint8_t> string_descriptor(const CameraModel& model, unsigned number);

}  // namespace glint::device
