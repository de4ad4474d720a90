// SPDX-License-Identifier: MIT
// One virtual trigger for all cameras: at each pulse every camera gets its picture, and goes wrong as
// scripted.
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "tests/device/frame_file/frame_file.hpp"
#include "tests/device/uvc_camera/fault_script.hpp"
#include "tests/device/uvc_camera/virtual_camera.hpp"

namespace glint::device {

struct TriggerOptions {
  double rate_hz = 90.0;
  std::uint64_t pulses = 0;
  std::int64_t read_out_ns = 2'000'000;  ///< from the pulse until the frame starts to leave the camera
};

/// Thread-bound.
class Trigger {
 public:
  using Cameras = std::deque<VirtualCamera>;
  /// All must outlive it.
  Trigger(const TriggerOptions& options, const FrameFile& frames, const FaultScript& faults,
          Cameras& cameras);

  /// Pulse 0 is at `first_ns`.
  void start(std::int64_t first_ns) noexcept { first_ns_ = first_ns; }
  bool started() const noexcept { return first_ns_ != 0; }
  bool done() const noexcept { return next_ >= options_.pulses; }
  std::uint64_t pulses() const noexcept { return next_; }
  /// The largest number before start() and after the last.
  std::int64_t next_ns() const noexcept;
  /// Instead of start(): somebody else fires each pulse; this one was at `pulse_ns`.
  void fire(std::int64_t pulse_ns);
  /// Fires all pulses that are due.
  void fire_due(std::int64_t now_ns);
  /// Plugs cameras back in whose time has come, as soon as their ports are free.
  void replug_waiting();

  /// CSV, a line for each pulse and camera: pulse,camera,time_ns,fault,watched. Throws Error.
  void write_log(const std::filesystem::path& path) const;

 private:
  struct Entry {
    std::uint64_t pulse = 0;
    std::int64_t time_ns = 0;
    unsigned camera = 0;
    std::string fault;
    bool watched = false;  // the host was streaming
  };
  std::int64_t time_ns(std::uint64_t pulse) const noexcept;
  void expose(std::uint64_t pulse, std::int64_t pulse_ns, unsigned camera);
  void act(const Fault& fault, unsigned camera);

  TriggerOptions options_;
  const FrameFile& frames_;
  const FaultScript& faults_;
  Cameras& cameras_;
  std::int64_t first_ns_ = 0;
  std::uint64_t next_ = 0;
  std::vector<std::uint64_t> slipped_;  // by camera: pulses that its pictures lie behind
  std::vector<bool> waits_for_port_;
  std::vector<Entry> log_;
};

}  // namespace glint::device
