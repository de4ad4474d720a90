// SPDX-License-Identifier: MIT
// One line ahead of the tick that is asked for.
#include "benchmarks/identity/points_file.hpp"

#include <charconv>
#include <limits>
#include <string>
#include <string_view>

namespace glint::identity {
namespace {

constexpr std::array<std::string_view, 15> kNames{"tick",    "id",    "x_m",       "y_m",   "z_m",
                                                  "cameras", "kind",  "ambiguous", "sd_m",  "xx_m2",
                                                  "xy_m2",   "xz_m2", "yy_m2",     "yz_m2", "zz_m2"};
constexpr std::uint64_t kLargestId = std::numeric_limits<std::uint32_t>::max();

}  // namespace

PointsFile::PointsFile(const std::filesystem::path& path, std::uint64_t ticks, std::uint32_t cameras)
    : csv_(path), ticks_(ticks), cameras_(cameras) {
  if (!csv_.next()) return;
  read_header();
  advance();
}

void PointsFile::read_header() {
  fields_ = csv_.fields();
  for (std::size_t field = 0; field < fields_; ++field) {
    for (std::size_t column = 0; column < kColumns; ++column) {
      if (csv_.text(field) != kNames[column]) continue;
      if (field_of_[column]) csv_.fail(field, "column \"" + std::string(kNames[column]) + "\" occurs twice");
      field_of_[column] = field;
      if (column > kZ) extras_ += (extras_.empty() ? "" : ", ") + std::string(kNames[column]);
    }
  }
  for (const Column needed : {kTick, kId, kX, kY, kZ})
    if (!field_of_[needed]) csv_.fail(fields_, "column \"" + std::string(kNames[needed]) + "\" is missing");
  for (std::size_t column = kXx; column < kColumns; ++column) {
    if (field_of_[column].has_value() != field_of_[kXx].has_value())
      csv_.fail(fields_, "a covariance has all of xx_m2, xy_m2, xz_m2, yy_m2, yz_m2 and zz_m2");
  }
  if (field_of_[kXx] && field_of_[kSd]) csv_.fail(*field_of_[kSd], "sd_m and a covariance: give one of them");
}

void PointsFile::advance() {
  const std::optional<std::uint64_t> before = tick_;
  tick_.reset();
  if (!csv_.next()) return;
  if (csv_.fields() != fields_) {
    csv_.fail(std::min(csv_.fields(), fields_),
              std::to_string(csv_.fields()) + " fields, but the first line has " + std::to_string(fields_));
  }
  const auto real = [&](Column column) { return csv_.real(*field_of_[column], kNames[column]); };
  tick_ = csv_.whole(*field_of_[kTick], "tick", std::numeric_limits<std::uint64_t>::max());
  if (before && *tick_ < *before) {
    csv_.fail(*field_of_[kTick],
              "tick goes back from " + std::to_string(*before) + " to " + std::to_string(*tick_));
  }
  if (*tick_ >= ticks_) {
    csv_.fail(*field_of_[kTick], "tick " + std::to_string(*tick_) + ", but the scene ends with tick " +
                                     std::to_string(ticks_ - 1));
  }
  sample_ = {};
  sample_.id = static_cast<std::uint32_t>(csv_.whole(*field_of_[kId], "id", kLargestId));
  sample_.position_in_world = {real(kX), real(kY), real(kZ)};
  sample_.cameras = camera_set();
  sample_.covariance_m2 = covariance();
  if (field_of_[kAmbiguous] && !csv_.text(*field_of_[kAmbiguous]).empty())
    sample_.ambiguous = csv_.whole(*field_of_[kAmbiguous], "ambiguous", kLargestId) != 0;
  if (!field_of_[kKind]) return;
  const std::string_view kind = csv_.text(*field_of_[kKind]);
  if (kind != "measured" && kind != "single-view" && kind != "predicted")
    csv_.fail(*field_of_[kKind],
              "kind \"" + std::string(kind) + "\" is not measured, single-view or predicted");
  sample_.predicted = kind != "measured";
}

std::uint32_t PointsFile::camera_set() const {
  std::uint32_t cameras = 0;
  if (!field_of_[kCameras]) return cameras;
  std::string_view rest = csv_.text(*field_of_[kCameras]);
  while (!rest.empty()) {
    unsigned camera = 0;
    const auto [end, problem] = std::from_chars(rest.data(), rest.data() + rest.size(), camera);
    const bool whole = end == rest.data() + rest.size();
    if (problem != std::errc{} || camera < 1 || camera > cameras_ || (!whole && *end != '+')) {
      csv_.fail(*field_of_[kCameras],
                "cameras are numbers from 1 to " + std::to_string(cameras_) + " joined by +, like 1+2+4");
    }
    cameras |= 1u << (camera - 1);
    rest.remove_prefix(static_cast<std::size_t>(end - rest.data()) + (whole ? 0 : 1));
  }
  return cameras;
}

Eigen::Matrix3d PointsFile::covariance() const {
  const auto real = [&](Column column) { return csv_.real(*field_of_[column], kNames[column]); };
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
  if (field_of_[kSd]) {
    const double sd_m = real(kSd);
    covariance_m2.diagonal().setConstant(sd_m * sd_m);
  }
  if (field_of_[kXx]) {
    covariance_m2 << real(kXx), real(kXy), real(kXz),  //
        real(kXy), real(kYy), real(kYz),               //
        real(kXz), real(kYz), real(kZz);
  }
  return covariance_m2;
}

void PointsFile::take(std::uint64_t tick, std::vector<IdentitySample>& samples) {
  samples.clear();
  while (tick_ && *tick_ == tick) {
    samples.push_back(sample_);
    advance();
  }
}

}  // namespace glint::identity
