// SPDX-License-Identifier: MIT
// One V4L2 capture device streaming into mapped buffers: the plainest program that a driver can meet.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace glint::device {

struct CaptureFormat {
  std::uint32_t fourcc = 0, width_px = 1280, height_px = 800;
  std::uint32_t rate_hz = 0;  ///< 0: as it stands
};

/// What one dequeued buffer says; `data` is valid until give_back().
struct CapturedBuffer {
  std::uint32_t index = 0, sequence = 0, flags = 0;
  std::int64_t stamp_us = 0;
  std::span<const std::uint8_t> data;
};

/// Opened and streaming as long as it lives.
class CaptureDevice {
 public:
  /// Throws Error with the call that failed.
  CaptureDevice(const std::string& path, const CaptureFormat& format, std::uint32_t buffers);
  ~CaptureDevice();
  CaptureDevice(CaptureDevice&& other) noexcept;
  CaptureDevice& operator=(CaptureDevice&&) = delete;

  int fd() const noexcept { return fd_; }
  /// Nothing when none is ready (problem() 0) or the device fails (problem() is the errno of DQBUF).
  std::optional<CapturedBuffer> take() noexcept;
  /// False when QBUF failed.
  bool give_back(const CapturedBuffer& buffer) noexcept;
  int problem() const noexcept { return problem_; }

 private:
  void close_all() noexcept;
  int fd_ = -1;
  int problem_ = 0;
  std::vector<std::span<std::uint8_t>> buffers_;
};

}  // namespace glint::device
