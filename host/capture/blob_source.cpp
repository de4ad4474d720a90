// SPDX-License-Identifier: MIT
// CSV files of blobs, merged into blob sets by tick.
#include "host/capture/blob_source.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <limits>
#include <optional>

#include "host/base/error.hpp"
#include "host/capture/camera_names.hpp"
#include "host/capture/csv_reader.hpp"

namespace glint {
namespace {

namespace fs = std::filesystem;

constexpr double kRateIfUnknown_hz = 30.0;
constexpr std::uint64_t kLargestU32 = std::numeric_limits<std::uint32_t>::max();
// Far beyond any image, and still exact to 1/16 px as float.
constexpr double kLargestCoordinate_px = 1e6;
constexpr double kLargestTime_ns = 9.0e18;

enum Column : std::size_t { kTick, kX, kY, kArea, kSum, kColumns };
constexpr std::array<std::string_view, kColumns> kColumnNames{"tick", "x_px", "y_px", "area_px", "sum"};

/// One camera's file, one line ahead.
class BlobFile {
 public:
  BlobFile(const fs::path& path, std::uint32_t camera) : csv_(path), camera_(camera) {
    for (std::size_t column = 0; column < kColumns; ++column) field_of_[column] = column;
    if (!csv_.next()) return;
    const std::string_view first = csv_.text(0);
    // A header begins with a letter, a tick with a digit.
    if (!first.empty() && ((first[0] >= 'a' && first[0] <= 'z') || (first[0] >= 'A' && first[0] <= 'Z'))) {
      read_header();
      advance();
    } else {
      if (csv_.fields() > kColumns)
        csv_.fail(kColumns, "too many columns; there are tick,x_px,y_px,area_px,sum");
      for (std::size_t column = csv_.fields(); column < kColumns; ++column) {
        if (column > kY) field_of_[column].reset();
      }
      fields_ = csv_.fields();
      parse();
    }
  }

  bool at_end() const noexcept { return at_end_; }
  std::uint64_t tick() const noexcept { return tick_; }

  /// Moves all blobs of that tick to `blobs`.
  void take(std::uint64_t tick, std::vector<gpu::BlobRecord>& blobs) {
    while (!at_end_ && tick_ == tick) {
      blobs.push_back(blob_);
      advance();
    }
  }

 private:
  void advance() {
    at_end_ = true;
    if (csv_.next()) parse();
  }

  void read_header() {
    field_of_.fill(std::nullopt);
    for (std::size_t field = 0; field < csv_.fields(); ++field) {
      const auto* const name = std::find(kColumnNames.begin(), kColumnNames.end(), csv_.text(field));
      if (name == kColumnNames.end()) {
        csv_.fail(field, "unknown column \"" + std::string(csv_.text(field)) +
                             "\"; there are tick,x_px,y_px,area_px,sum");
      }
      auto& place = field_of_[static_cast<std::size_t>(name - kColumnNames.begin())];
      if (place) csv_.fail(field, "column \"" + std::string(*name) + "\" occurs twice");
      place = field;
    }
    for (const Column needed : {kTick, kX, kY}) {
      if (!field_of_[needed]) {
        csv_.fail(csv_.fields(), "column \"" + std::string(kColumnNames[needed]) + "\" is missing");
      }
    }
    fields_ = csv_.fields();
  }

  std::uint32_t optional_whole(Column column) const {
    if (!field_of_[column]) return 0;
    return static_cast<std::uint32_t>(csv_.whole(*field_of_[column], kColumnNames[column], kLargestU32));
  }

  double coordinate(Column column) const {
    const double value = csv_.real(*field_of_[column], kColumnNames[column]);
    if (std::abs(value) > kLargestCoordinate_px) {
      csv_.fail(*field_of_[column], std::string(kColumnNames[column]) + " is not within +-1000000");
    }
    return value;
  }

  void parse() {
    if (csv_.fields() > fields_) {
      csv_.fail(fields_, "too many columns: the first line has " + std::to_string(fields_));
    }
    const std::uint64_t tick =
        csv_.whole(*field_of_[kTick], "tick", std::numeric_limits<std::uint64_t>::max());
    if (any_ && tick < tick_) {
      csv_.fail(*field_of_[kTick],
                "tick goes back from " + std::to_string(tick_) + " to " + std::to_string(tick));
    }
    const double x_px = coordinate(kX), y_px = coordinate(kY);
    blob_ = {};
    blob_.camera = camera_;
    blob_.area_px = optional_whole(kArea);
    blob_.sum = optional_whole(kSum);
    blob_.x_px = static_cast<float>(x_px);
    blob_.y_px = static_cast<float>(y_px);
    const auto pixel = [](double at_px) {
      return static_cast<std::uint32_t>(std::lround(std::max(0.0, at_px)));
    };
    blob_.x_min_px = blob_.x_max_px = pixel(x_px);
    blob_.y_min_px = blob_.y_max_px = pixel(y_px);
    tick_ = tick;
    any_ = true;
    at_end_ = false;
  }

  CsvReader csv_;
  std::uint32_t camera_;
  std::array<std::optional<std::size_t>, kColumns> field_of_;
  std::size_t fields_ = 0;
  std::uint64_t tick_ = 0;
  gpu::BlobRecord blob_{};
  bool any_ = false, at_end_ = true;
};

class CsvBlobSource final : public BlobSource {
 public:
  CsvBlobSource(const std::vector<std::pair<std::string, fs::path>>& cameras, double rate_hz)
      : rate_hz_(rate_hz > 0.0 ? rate_hz : kRateIfUnknown_hz) {
    for (const auto& [name, path] : cameras) {
      files_.push_back(std::make_unique<BlobFile>(path, static_cast<std::uint32_t>(files_.size())));
      described_.push_back({name, {}});
    }
    if (std::all_of(files_.begin(), files_.end(), [](const auto& file) { return file->at_end(); })) {
      throw Error(cameras.front().second.parent_path().string() + ": all blob files are empty");
    }
    if (rate_hz <= 0.0) problem_ = "no tick rate is known: time stamps assume 30 Hz";
  }

  std::span<const SourceCamera> cameras() const noexcept override { return described_; }
  const std::string& problem() const noexcept override { return problem_; }

  [[nodiscard]] ReadStatus read(BlobSet& set) noexcept override {
    if (failed_) return ReadStatus::Failed;
    try {
      return read_tick(set);
    } catch (const std::exception& error) {
      failed_ = true;
      problem_ = error.what();
      return ReadStatus::Failed;
    }
  }

 private:
  ReadStatus read_tick(BlobSet& set) {
    std::optional<std::uint64_t> tick;
    for (const auto& file : files_) {
      if (!file->at_end() && (!tick || file->tick() < *tick)) tick = file->tick();
    }
    if (!tick) return ReadStatus::End;
    set.cameras.resize(files_.size());
    for (std::size_t n = 0; n < files_.size(); ++n) {
      set.cameras[n].clear();
      files_[n]->take(*tick, set.cameras[n]);
    }
    set.trigger = TriggerNo{*tick};
    const double time_ns = std::min(static_cast<double>(*tick) / rate_hz_ * 1e9, kLargestTime_ns);
    set.exposed = Timestamp(std::chrono::nanoseconds(std::llround(time_ns)));
    set.delivered = std::chrono::steady_clock::now();
    return ReadStatus::Ok;
  }

  std::vector<std::unique_ptr<BlobFile>> files_;
  std::vector<SourceCamera> described_;
  double rate_hz_;
  std::string problem_;
  bool failed_ = false;
};

}  // namespace

void BlobSourceOptions::check(std::vector<std::string>& problems) const {
  if (!(rate_hz >= 0.0 && rate_hz <= 1e6)) problems.emplace_back("source.rate_hz must be 0 to 1000000");
}

std::unique_ptr<BlobSource> open_blob_source(const std::string& folder, const BlobSourceOptions& options) {
  std::vector<std::string> problems;
  options.check(problems);
  if (!problems.empty()) throw Error(join_names(problems));
  std::error_code error;
  std::vector<std::string> names;
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    if (at->path().extension() == ".csv" && at->is_regular_file())
      names.push_back(at->path().stem().string());
  }
  if (error) throw Error(folder + ": cannot be listed: " + error.message());
  if (names.empty())
    throw Error(folder + ": holds no CSV files; expected one per camera, named like the camera");
  std::sort(names.begin(), names.end(), natural_less);
  std::vector<std::pair<std::string, fs::path>> cameras;
  for (const std::size_t n : select_cameras(names, options.camera_names, folder)) {
    cameras.emplace_back(names[n], fs::path(folder) / (names[n] + ".csv"));
  }
  return std::make_unique<CsvBlobSource>(cameras, options.rate_hz);
}

}  // namespace glint
