// SPDX-License-Identifier: MIT
// What stands behind `images:`: folders, files or addresses, told apart and opened.
#include "host/capture/image_source.hpp"

#include <algorithm>
#include <filesystem>
#include <map>

#include "host/base/error.hpp"
#include "host/capture/camera_names.hpp"
#include "host/capture/network_source.hpp"
#include "host/capture/recorded_source.hpp"
#include "host/capture/recording.hpp"
#include "host/capture/still_decoder.hpp"
#include "host/capture/video_decoder.hpp"

namespace glint {
namespace {

namespace fs = std::filesystem;

/// One camera before it is opened: numbered images, or a video, or an address.
struct Candidate {
  std::string name;
  std::vector<fs::path> stills;
  std::string video_or_address;
  bool network = false;
};

bool is_hidden(const fs::path& path) { return path.filename().string().starts_with('.'); }

std::vector<fs::path> entries_of(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> entries;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    if (!is_hidden(at->path())) entries.push_back(at->path());
  }
  if (error) throw Error(folder.string() + ": cannot be listed: " + error.message());
  std::sort(entries.begin(), entries.end());
  return entries;
}

/// A folder that belongs to one camera; nothing if it holds no pictures.
std::optional<Candidate> camera_in_folder(const fs::path& folder, const std::string& name) {
  Candidate candidate;
  candidate.name = name;
  std::vector<fs::path> videos;
  for (const fs::path& entry : entries_of(folder)) {
    if (!fs::is_regular_file(entry)) continue;
    if (has_image_extension(entry)) candidate.stills.push_back(entry);
    if (has_video_extension(entry)) videos.push_back(entry);
  }
  if (candidate.stills.empty() && videos.empty()) return std::nullopt;
  if (videos.size() + (candidate.stills.empty() ? 0 : 1) > 1) {
    throw Error(folder.string() + ": holds " + std::to_string(videos.size()) + " videos and " +
                std::to_string(candidate.stills.size()) +
                " images; a camera's folder holds numbered images or one video");
  }
  if (!videos.empty()) candidate.video_or_address = videos.front().string();
  return candidate;
}

std::vector<Candidate> cameras_in_folder(const fs::path& folder) {
  std::vector<Candidate> found;
  std::size_t loose_images = 0;
  for (const fs::path& entry : entries_of(folder)) {
    if (fs::is_directory(entry)) {
      if (auto camera = camera_in_folder(entry, entry.filename().string()))
        found.push_back(std::move(*camera));
    } else if (has_video_extension(entry)) {
      found.push_back({entry.stem().string(), {}, entry.string(), false});
    } else if (has_image_extension(entry)) {
      ++loose_images;
    }
  }
  if (found.empty()) {
    throw Error(
        folder.string() + ": holds no cameras" +
        (loose_images > 0 ? " (" + std::to_string(loose_images) + " images lie beside each other)" : "") +
        "; expected one sub-folder of numbered images per camera, or one video file per camera");
  }
  std::sort(found.begin(), found.end(),
            [](const Candidate& a, const Candidate& b) { return natural_less(a.name, b.name); });
  return found;
}

bool is_address(const std::string& text) {
  return text.find("://") != std::string::npos && !text.starts_with("file://");
}

/// `name=` in front of a path or address; the name is made of letters, digits, '_', '-' and '.'.
std::string take_name(std::string& item) {
  const std::size_t equals = item.find('=');
  if (equals == std::string::npos || equals == 0) return "";
  const auto is_name_letter = [](char c) {
    return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' ||
           c == '-' || c == '.';
  };
  const auto end = item.begin() + static_cast<std::ptrdiff_t>(equals);
  if (!std::all_of(item.begin(), end, is_name_letter)) return "";
  std::string name = item.substr(0, equals);
  item.erase(0, equals + 1);
  return name;
}

Candidate candidate_of(std::string item, const std::string& name) {
  if (is_address(item)) return {name, {}, std::move(item), true};
  if (item.starts_with("file://")) item.erase(0, std::string_view("file://").size());
  const fs::path path(item);
  if (fs::is_directory(path)) {
    if (auto camera = camera_in_folder(path, name)) return std::move(*camera);
    throw Error(item + ": holds no images and no video");
  }
  if (!fs::exists(path)) throw Error(item + ": no such file or folder");
  if (has_image_extension(path)) return {name, {path}, "", false};
  return {name, {}, item, false};
}

std::vector<Candidate> cameras_in_list(const std::string& list, const std::vector<std::string>& wanted) {
  std::vector<std::pair<std::string, std::string>> items;  // name, path or address
  for (std::size_t begin = 0; begin <= list.size();) {
    const std::size_t end = std::min(list.find(',', begin), list.size());
    std::string item = list.substr(begin, end - begin);
    if (item.empty())
      throw Error("images:" + without_password(list) + ": an empty entry in the list of cameras");
    std::string name = take_name(item);
    items.emplace_back(std::move(name), std::move(item));
    begin = end + 1;
  }
  const bool all_unnamed =
      std::all_of(items.begin(), items.end(), [](const auto& item) { return item.first.empty(); });
  const bool as_wanted = all_unnamed && wanted.size() == items.size();
  std::vector<Candidate> found;
  for (std::size_t n = 0; n < items.size(); ++n) {
    auto& [name, item] = items[n];
    if (name.empty()) name = as_wanted ? wanted[n] : "cam" + std::to_string(n + 1);
    found.push_back(candidate_of(std::move(item), name));
  }
  return found;
}

void check_sizes(const FrameSource& source, const std::vector<std::string>& origins,
                 const ImageSourceOptions& options) {
  std::string problems;
  for (std::size_t n = 0; n < options.camera_sizes.size() && n < options.camera_names.size(); ++n) {
    const FrameSize wanted = options.camera_sizes[n], is = source.cameras()[n].size;
    if (wanted.width_px == 0 && wanted.height_px == 0) continue;
    if (wanted.width_px == is.width_px && wanted.height_px == is.height_px) continue;
    problems += (problems.empty() ? "camera " : "\ncamera ") + source.cameras()[n].name + ": " + origins[n] +
                " is " + std::to_string(is.width_px) + "x" + std::to_string(is.height_px) +
                ", but the rig says " + std::to_string(wanted.width_px) + "x" +
                std::to_string(wanted.height_px);
  }
  if (!problems.empty()) throw Error(problems + "; use the calibration that was made at this frame size");
}

std::unique_ptr<FrameSource> open_recorded(const std::vector<Candidate>& cameras,
                                           const std::vector<std::string>& all_names, const fs::path& folder,
                                           const ImageSourceOptions& options) {
  std::vector<CameraRecording> recordings;
  std::vector<std::string> origins, ignored;
  for (const Candidate& camera : cameras) {
    CameraRecording recording{camera.name, nullptr};
    try {
      recording.recording = camera.stills.empty() ? open_video_recording(camera.video_or_address)
                                                  : open_still_recording(camera.stills, ignored);
    } catch (const Error& error) {
      throw Error("camera " + camera.name + ": " + error.what());
    }
    origins.push_back(recording.recording->first_path());
    recordings.push_back(std::move(recording));
  }
  std::optional<FrameLog> log;
  if (!folder.empty() && fs::exists(folder / "frames.csv")) log.emplace(folder / "frames.csv", all_names);
  auto source = std::make_unique<RecordedSource>(std::move(recordings), std::move(log), ignored, options);
  check_sizes(*source, origins, options);
  return source;
}

std::unique_ptr<FrameSource> open_network(const std::vector<Candidate>& cameras,
                                          const ImageSourceOptions& options) {
  std::vector<NetworkCamera> network;
  std::vector<std::string> origins;
  for (const Candidate& camera : cameras) {
    network.push_back({camera.name, camera.video_or_address});
    origins.push_back(without_password(camera.video_or_address));
  }
  auto source = std::make_unique<NetworkSource>(network, options);
  check_sizes(*source, origins, options);
  return source;
}

}  // namespace

void ImageSourceOptions::check(std::vector<std::string>& problems) const {
  if (!(rate_hz >= 0.0 && rate_hz <= 1e6)) problems.emplace_back("source.rate_hz must be 0 to 1000000");
  if (!(open_timeout_s > 0.0 && open_timeout_s <= 3600.0)) {
    problems.emplace_back("source.open_timeout_s must be above 0 and at most 3600");
  }
  if (!(silence_s > 0.0 && silence_s <= 3600.0)) {
    problems.emplace_back("source.silence_s must be above 0 and at most 3600");
  }
  if (!camera_sizes.empty() && camera_sizes.size() != camera_names.size()) {
    problems.emplace_back("source.camera_sizes must be as many as source.camera_names");
  }
}

std::unique_ptr<FrameSource> open_image_source(const std::string& location,
                                               const ImageSourceOptions& options) {
  std::vector<std::string> problems;
  options.check(problems);
  if (!problems.empty()) throw Error(join_names(problems));
  if (location.empty()) throw Error("images: needs a folder, files or addresses behind the colon");
  const bool is_folder = fs::is_directory(location);
  if (!is_folder && !is_address(location) && location.find_first_of(",=") == std::string::npos &&
      !fs::exists(location)) {
    throw Error(location + ": no such file or folder");
  }
  const std::vector<Candidate> found =
      is_folder ? cameras_in_folder(location) : cameras_in_list(location, options.camera_names);

  std::vector<std::string> names;
  for (const Candidate& camera : found) names.push_back(camera.name);
  const std::string where = is_folder ? location : "images:" + join_names(names);
  std::vector<Candidate> cameras;
  for (const std::size_t n : select_cameras(names, options.camera_names, where)) cameras.push_back(found[n]);

  const auto network =
      std::count_if(cameras.begin(), cameras.end(), [](const Candidate& c) { return c.network; });
  if (network == 0)
    return open_recorded(cameras, names, is_folder ? fs::path(location) : fs::path(), options);
  if (network == std::ssize(cameras)) return open_network(cameras, options);
  throw Error(where + ": network cameras and recordings cannot be mixed");
}

}  // namespace glint
