// SPDX-License-Identifier: MIT
// Reader of frames.csv.
#include "host/capture/frame_log.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <string_view>

#include "host/base/error.hpp"
#include "host/capture/camera_names.hpp"
#include "host/capture/csv_reader.hpp"

namespace glint {
namespace {

enum Column : std::size_t { kCamera, kFrame, kSequence, kTime, kColumns };
constexpr std::array<std::string_view, kColumns> kColumnNames{"camera", "frame", "sequence", "time_ns"};
constexpr std::int64_t kLargestTime_ns = 4'000'000'000'000'000'000;  // room to add durations without overflow

std::array<std::optional<std::size_t>, kColumns> read_header(const CsvReader& csv) {
  std::array<std::optional<std::size_t>, kColumns> at;
  for (std::size_t field = 0; field < csv.fields(); ++field) {
    const auto* const name = std::find(kColumnNames.begin(), kColumnNames.end(), csv.text(field));
    if (name == kColumnNames.end()) {
      csv.fail(field, "unknown column \"" + std::string(csv.text(field)) +
                          "\"; the header line is camera,frame,sequence,time_ns");
    }
    auto& place = at[static_cast<std::size_t>(name - kColumnNames.begin())];
    if (place) csv.fail(field, "column \"" + std::string(*name) + "\" occurs twice");
    place = field;
  }
  for (const Column needed : {kCamera, kFrame, kSequence}) {
    if (!at[needed])
      csv.fail(csv.fields(), "column \"" + std::string(kColumnNames[needed]) + "\" is missing");
  }
  return at;
}

}  // namespace

FrameLog::FrameLog(const std::filesystem::path& path, const std::vector<std::string>& cameras) {
  CsvReader csv(path);
  if (!csv.next()) throw Error(path.string() + ":1: empty; it begins with camera,frame,sequence,time_ns");
  const auto at = read_header(csv);
  constexpr std::uint64_t kLargest = std::numeric_limits<std::uint64_t>::max();

  struct Last {
    std::uint64_t frame = 0, sequence = 0;
    std::optional<std::int64_t> time_ns;
  };
  std::map<std::string, Last> last_of_camera;
  while (csv.next()) {
    if (*at[kCamera] >= csv.fields()) csv.fail(csv.fields(), "camera is missing");
    const std::string camera(csv.text(*at[kCamera]));
    if (std::find(cameras.begin(), cameras.end(), camera) == cameras.end()) {
      csv.fail(*at[kCamera],
               "no camera \"" + camera + "\" in this recording; there are " + join_names(cameras));
    }
    const std::uint64_t frame = csv.whole(*at[kFrame], "frame", kLargest);
    FrameStamp stamp;
    stamp.sequence = csv.whole(*at[kSequence], "sequence", kLargest);
    if (at[kTime] && *at[kTime] < csv.fields() && !csv.text(*at[kTime]).empty()) {
      stamp.time_ns = csv.signed_whole(*at[kTime], "time_ns");
      if (*stamp.time_ns < -kLargestTime_ns || *stamp.time_ns > kLargestTime_ns) {
        csv.fail(*at[kTime], "time_ns must be within +-" + std::to_string(kLargestTime_ns));
      }
    }
    if (const auto last = last_of_camera.find(camera); last != last_of_camera.end()) {
      if (frame <= last->second.frame) csv.fail(*at[kFrame], "frames of a camera must ascend");
      if (stamp.sequence < last->second.sequence) csv.fail(*at[kSequence], "sequence goes back");
      if (stamp.time_ns && last->second.time_ns && *stamp.time_ns < *last->second.time_ns) {
        csv.fail(*at[kTime], "time_ns goes back");
      }
    }
    last_of_camera[camera] = {frame, stamp.sequence, stamp.time_ns};
    cameras_[camera].emplace(frame, stamp);
  }
}

const FrameStamp* FrameLog::find(const std::string& camera, std::uint64_t frame) const {
  const auto frames = cameras_.find(camera);
  if (frames == cameras_.end()) return nullptr;
  const auto stamp = frames->second.find(frame);
  return stamp == frames->second.end() ? nullptr : &stamp->second;
}

}  // namespace glint
