// SPDX-License-Identifier: MIT
// frames.csv: when each stored frame was exposed, and as which exposure of the rig.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

namespace glint {

struct FrameStamp {
  std::uint64_t sequence = 0;
  std::optional<std::int64_t> time_ns;
};

/// The file has a header line with the columns, in any order:
///
///  - `camera`: the camera's name;
///  - `frame`: which frame of that camera: the number in the file's name, or for videos the frame's place,
///  from 0;
///  - `sequence`: number of the exposure, from the driver or the trigger: frames of equal sequence belong
///  together, and a
///    gap is a lost exposure; the same sequence twice in one camera is a duplicate, and the first frame is
///    used;
///  - `time_ns` (may be left out, or empty in a line): middle of the exposure in nanoseconds, on a clock that
///  never
///    goes back, with any start.
///
/// Within a camera, frames ascend and neither sequence nor time goes back.
class FrameLog {
 public:
  /// Throws Error as file:line:column. Every camera named must be one of `cameras`.
  FrameLog(const std::filesystem::path& path, const std::vector<std::string>& cameras);

  /// Nothing if the file has no line for that frame.
  const FrameStamp* find(const std::string& camera, std::uint64_t frame) const;
  bool has_camera(const std::string& camera) const { return cameras_.contains(camera); }

 private:
  std::map<std::string, std::unordered_map<std::uint64_t, FrameStamp>> cameras_;
};

}  // namespace glint
