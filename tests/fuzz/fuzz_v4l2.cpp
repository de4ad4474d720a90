// SPDX-License-Identifier: MIT
// Any bytes as the answers of V4L2 drivers, in the drivers' own time.
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "tests/fuzz/v4l2_trials.hpp"
#include "tests/support/temp_dir.hpp"

namespace glint::test {

const std::string& node_path(std::size_t camera) {
  static const TempDir folder;
  static const std::array kPaths{folder.write("video0", "").string(), folder.write("video1", "").string(),
                                 folder.write("video2", "").string()};
  return kPaths.at(camera);
}

bool all_slots_free(FramePool& pool, CameraId camera, std::uint32_t slots) {
  std::vector<Frame> taken;
  while (std::optional<Frame> slot = pool.take(camera)) taken.push_back(std::move(*slot));
  return taken.size() == slots;
}

}  // namespace glint::test

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  glint::test::ByteChoices choices({data, size});
  switch (choices.below(16)) {
    case 0:
      glint::test::try_list(choices);
      break;
    case 1:
    case 2:
      glint::test::try_feed(choices);
      break;
    default:
      glint::test::try_streams(choices);
  }
  return 0;
}
