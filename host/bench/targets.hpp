// SPDX-License-Identifier: MIT
// What is measured: Vulkan devices and the native detector.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "gpu/detector.hpp"
#include "host/bench/results.hpp"
#include "host/bench/scene.hpp"

namespace glint::bench {

struct Target {
  std::optional<gpu::DeviceInfo> vulkan;  ///< nothing: the native CPU detector
};

/// Each device that `wanted` names once: "cpu", or an index, a UUID or part of a name. With an empty `wanted`
/// every usable Vulkan device and the CPU; `notes` then says which devices were left out and why. Throws
/// Error that lists what there is.
std::vector<Target> choose_targets(std::span<const std::string> wanted, std::vector<std::string>& notes);

/// What is known of a target before it has run.
DeviceResult describe(const Target& target);

struct TargetOptions {
  unsigned threads = 2;  ///< of the CPU detector
  unsigned depth = 2;
};

/// A detector for the first `cameras` cameras of a scene, with their limits, to which the scene's memory has
/// been offered as live capture offers its own.
struct PreparedDetector {
  std::unique_ptr<gpu::Detector> detector;
  bool adopted_frame_memory = false;
};
/// Throws Error or gpu::Error.
PreparedDetector make_detector(const Target& target, Scene& scene, unsigned cameras,
                               const TargetOptions& options);

}  // namespace glint::bench
