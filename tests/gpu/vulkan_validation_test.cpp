// SPDX-License-Identifier: MIT
// The validation layer has nothing to say about the detector, and says something as soon as a barrier is
// missing.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "gpu/vulkan/detector_vulkan.hpp"
#include "tests/gpu/compare_blobs.hpp"
#include "tests/gpu/detector_cases.hpp"
#include "tests/gpu/test_images.hpp"

namespace glint::gpu::testing {
namespace {

using Messages = std::vector<std::string>;

DetectorOptions listening(Messages& messages) {
  DetectorOptions options;
  options.on_validation_message = [&messages](const std::string& text) { messages.push_back(text); };
  return options;
}

std::string first_of(const Messages& messages) { return messages.empty() ? "" : messages.front(); }

// Few blobs (fused step only), many candidate tiles (split steps), and more blobs than room.
std::vector<std::vector<TestImage>> frame_sets() {
  std::vector<std::vector<TestImage>> sets;
  sets.push_back({soft_spots(641, 479, 12, 20.0, 1), all_black(33, 9)});
  sets.push_back({noise_image(641, 479, 0.5, 2), all_white(33, 9)});
  sets.push_back({dot_grid(641, 479), noise_image(33, 9, 0.3, 3)});
  return sets;
}

class VulkanValidation : public ::testing::TestWithParam<DetectorCase> {};

TEST_P(VulkanValidation, IsSilent) {
  Messages messages;
  for (const std::vector<TestImage>& images : frame_sets()) {
    FrameMemory memory(images, GetParam().layout);
    const auto detector = GetParam().make(formats_of(images), listening(messages));
    set_limits(*detector, images);
    if (GetParam().adopt) (void)detector->adopt_frame_memory(memory.memory());
    for (int round = 0; round < 2; ++round) (void)detect(*detector, memory.views());
  }
  EXPECT_EQ(messages.size(), 0u) << first_of(messages);
}

std::vector<DetectorCase> vulkan_cases() {
  std::vector<DetectorCase> cases = detector_cases();
  std::erase_if(cases, [](const DetectorCase& c) { return !c.on_gpu(); });
  return cases;
}

INSTANTIATE_TEST_SUITE_P(Devices, VulkanValidation, ::testing::ValuesIn(vulkan_cases()), case_name);
GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(VulkanValidation);

class MissingBarrier : public ::testing::TestWithParam<int> {};

TEST_P(MissingBarrier, IsReported) {
  const std::vector<DeviceInfo> devices = list_devices();
  const auto usable =
      std::find_if(devices.begin(), devices.end(), [](const DeviceInfo& d) { return d.usable; });
  if (usable == devices.end()) GTEST_SKIP() << "no Vulkan device";
  Messages messages;
  const std::vector<TestImage> images{noise_image(641, 479, 0.5, 4)};
  FrameMemory memory(images, Layout::Aligned);
  const auto detector = make_vulkan_detector(*usable, formats_of(images), listening(messages),
                                             VulkanTestHooks{GetParam(), {}, {}});
  set_limits(*detector, images);
  (void)detect(*detector, memory.views());
  EXPECT_TRUE(std::any_of(messages.begin(), messages.end(),
                          [](const std::string& m) { return m.find("SYNC-HAZARD") != std::string::npos; }))
      << "barrier " << GetParam() << " can be left out and nobody notices; " << messages.size()
      << " messages";
}

INSTANTIATE_TEST_SUITE_P(Barriers, MissingBarrier, ::testing::Range(0, kBarriers));

}  // namespace
}  // namespace glint::gpu::testing
