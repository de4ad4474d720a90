// SPDX-License-Identifier: MIT
// One fake camera, opened and streaming.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/capture/v4l2/camera_stream.hpp"
#include "tests/support/temp_dir.hpp"
#include "tests/unit/capture/fake_v4l2.hpp"

namespace glint::test {

/// A tree without any device: paths are taken as they are.
class StreamFixture {
 public:
  StreamFixture() : path_(temp_.write("video0", "").string()) { driver_.add(path_); }

  FakeCamera& camera() { return driver_.add(path_); }
  CameraRequest request() const {
    CameraRequest request;
    request.name = "left";
    request.device = path_;
    request.format = {std::nullopt, {64, 48}, 100.0};
    request.pulse_rate_hz = 100.0;
    return request;
  }
  DeviceRoots roots() const { return {temp_.path() / "dev", temp_.path() / "sys"}; }

  void start(const CameraRequest& request, std::uint32_t slots = 16) {
    received_.frame = {};
    stream_.reset();
    pool_.reset();
    stream_ = std::make_unique<CameraStream>(driver_, roots(), request);
    pool_ = std::make_unique<FramePool>(std::vector<FrameSize>{stream_->format().size}, slots);
    stream_->start(*pool_, CameraId{0});
  }
  void start() { start(request()); }
  StreamStatus next(std::chrono::milliseconds longest = std::chrono::milliseconds(50)) {
    return stream_->next(received_, longest);
  }
  /// The next frame; anything but "nothing yet" before it ends the search.
  StreamStatus next_frame() {
    for (int tries = 0; tries < 100; ++tries) {
      const StreamStatus status = next();
      if (status != StreamStatus::Nothing) return status;
    }
    return StreamStatus::Nothing;
  }

  std::uint8_t pixel(std::size_t x, std::size_t y) {
    return received_.frame.pixels()[y * received_.frame.stride_bytes() + x];
  }

  TempDir temp_;
  std::string path_;
  FakeV4l2 driver_;
  std::unique_ptr<FramePool> pool_;
  ReceivedFrame received_;
  std::unique_ptr<CameraStream> stream_;  // before the pool ends
};

/// What an Error says; "" if none is thrown.
template <typename Call>
std::string error_of(const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

}  // namespace glint::test
