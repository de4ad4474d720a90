// SPDX-License-Identifier: MIT
// Every detector that can run here, in every way that it can be given frames.
#pragma once

#include <iosfwd>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "gpu/detector.hpp"
#include "gpu/vulkan/detector_vulkan.hpp"
#include "tests/gpu/test_images.hpp"

namespace glint::gpu::testing {

struct DetectorCase {
  std::string name;         // letters, digits and _ only: part of the test's name
  std::string device;       // for make_detector(); empty: the CPU detector with `kernels`
  std::size_t kernels = 0;  // index into row_kernels()
  unsigned threads = 1;
  FramePath frame_path = FramePath::Auto;
  bool adopt = false;  // offer the frames' memory
  Layout layout = Layout::Aligned;
  VulkanTestHooks hooks;

  bool on_gpu() const noexcept { return !device.empty(); }
  bool forced() const noexcept { return hooks.fused_tiles || hooks.submit_together; }
  std::unique_ptr<Detector> make(std::span<const CameraFormat> cameras, DetectorOptions options) const;
};

void PrintTo(const DetectorCase& detector, std::ostream* out);

/// CPU kernels and thread counts, and each usable Vulkan device with each frame path.
std::vector<DetectorCase> detector_cases();
/// One way per device: for tests that do not depend on how frames get in.
std::vector<DetectorCase> one_case_per_device();

inline std::string case_name(const ::testing::TestParamInfo<DetectorCase>& info) { return info.param.name; }

}  // namespace glint::gpu::testing
