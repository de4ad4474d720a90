// SPDX-License-Identifier: MIT
// Numbered image files as the recording of one camera.
#include <algorithm>
#include <charconv>
#include <set>

#include "host/base/error.hpp"
#include "host/capture/recording.hpp"
#include "host/capture/still_decoder.hpp"

namespace glint {
namespace {

/// All runs of digits in a file's stem, last first.
std::vector<std::uint64_t> numbers_in(const std::string& stem) {
  std::vector<std::uint64_t> numbers;
  for (std::size_t at = 0; at < stem.size();) {
    std::uint64_t value = 0;
    const auto [end, error] = std::from_chars(stem.data() + at, stem.data() + stem.size(), value);
    const auto behind = static_cast<std::size_t>(end - stem.data());
    if (behind == at) {
      ++at;
      continue;
    }
    if (error == std::errc()) numbers.insert(numbers.begin(), value);
    at = behind;
  }
  return numbers;
}

struct NumberedFile {
  std::uint64_t number = 0;
  std::filesystem::path path;
};

/// Takes from each name the last number that tells all files apart: frame_0001_cam2.png counts by the 1, not
/// the 2.
std::vector<NumberedFile> number_files(const std::vector<std::filesystem::path>& files,
                                       std::vector<std::string>& ignored) {
  std::vector<std::pair<std::filesystem::path, std::vector<std::uint64_t>>> candidates;
  std::size_t places = 0;
  for (const std::filesystem::path& file : files) {
    std::vector<std::uint64_t> numbers = numbers_in(file.stem().string());
    if (numbers.empty()) {
      ignored.push_back(file.string());
      continue;
    }
    places = candidates.empty() ? numbers.size() : std::min(places, numbers.size());
    candidates.emplace_back(file, std::move(numbers));
  }
  if (candidates.empty()) {
    throw Error(files.front().parent_path().string() +
                ": no image there has a number in its name; name them like 0001.png");
  }
  const auto distinct = [&](std::size_t place) {
    std::set<std::uint64_t> seen;
    return std::all_of(candidates.begin(), candidates.end(),
                       [&](const auto& candidate) { return seen.insert(candidate.second[place]).second; });
  };
  std::size_t place = 0;
  while (place < places && !distinct(place)) ++place;
  if (place == places) place = 0;
  std::vector<NumberedFile> numbered;
  for (auto& [path, numbers] : candidates) numbered.push_back({numbers[place], std::move(path)});
  std::sort(numbered.begin(), numbered.end(), [](const NumberedFile& a, const NumberedFile& b) {
    return a.number != b.number ? a.number < b.number : a.path < b.path;
  });
  for (std::size_t n = 1; n < numbered.size(); ++n) {
    if (numbered[n].number == numbered[n - 1].number) {
      throw Error(numbered[n].path.string() + ": has the same number as " + numbered[n - 1].path.string());
    }
  }
  return numbered;
}

class StillRecording final : public Recording {
 public:
  StillRecording(const std::vector<std::filesystem::path>& files, std::vector<std::string>& ignored)
      : files_(number_files(files, ignored)), first_path_(files_.front().path.string()) {
    for (const NumberedFile& file : files_) numbers_.push_back(file.number);
    if (!decoder_.load(files_.front().path)) throw Error(decoder_.problem());
    size_ = decoder_.size();
    deep_ = decoder_.deep();
  }

  FrameSize size() const noexcept override { return size_; }
  double rate_hz() const noexcept override { return 0.0; }
  const std::string& first_path() const noexcept override { return first_path_; }
  const std::vector<std::uint64_t>& numbers() const noexcept override { return numbers_; }
  std::optional<double> next_time_s() const override { return std::nullopt; }
  bool deep() const noexcept override { return deep_; }
  const std::string& problem() const noexcept override { return problem_; }
  void skip() override { ++next_; }

  std::optional<std::uint64_t> next_number() override {
    if (next_ < files_.size()) return files_[next_].number;
    problem_.clear();
    return std::nullopt;
  }

  bool take(const GreyTarget& target) override {
    const std::filesystem::path& path = files_[next_++].path;
    if (!decoder_.load(path)) {
      problem_ = decoder_.problem();
      return false;
    }
    const FrameSize size = decoder_.size();
    if (size.width_px != size_.width_px || size.height_px != size_.height_px) {
      problem_ = path.string() + ": is " + std::to_string(size.width_px) + "x" +
                 std::to_string(size.height_px) + ", but " + first_path_ + " is " +
                 std::to_string(size_.width_px) + "x" + std::to_string(size_.height_px);
      return false;
    }
    deep_ = deep_ || decoder_.deep();
    if (decoder_.copy_to(target)) return true;
    problem_ = decoder_.problem();
    return false;
  }

 private:
  std::vector<NumberedFile> files_;
  std::vector<std::uint64_t> numbers_;
  std::string first_path_, problem_;
  StillDecoder decoder_;
  FrameSize size_;
  std::size_t next_ = 0;
  bool deep_ = false;
};

}  // namespace

std::unique_ptr<Recording> open_still_recording(std::vector<std::filesystem::path> files,
                                                std::vector<std::string>& ignored) {
  return std::make_unique<StillRecording>(files, ignored);
}

}  // namespace glint
