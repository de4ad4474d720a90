// SPDX-License-Identifier: MIT
// The points of any tracker, from a CSV file.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "host/capture/csv_reader.hpp"
#include "host/sim/identity_score.hpp"

namespace glint::identity {

/// The first line names the columns, in any order: tick, id, x_m, y_m, z_m; and if wanted cameras ("1+2+4",
/// from 1), kind ("measured", "single-view", "predicted"), ambiguous (0 or empty: no; 1 or
/// the id of the other track: yes), sd_m (per axis, root mean square over the three; 0: unknown)
/// or all of xx_m2, xy_m2, xz_m2, yy_m2, yz_m2, zz_m2. Other columns are passed over. Ticks do not go back.
/// Errors are thrown as Error("file:line:column: what").
class PointsFile {
 public:
  PointsFile(const std::filesystem::path& path, std::uint64_t ticks, std::uint32_t cameras);

  /// Replaces `samples` with those of that tick; ask for every tick in order. Throws at a line of no tick
  /// that is asked for.
  void take(std::uint64_t tick, std::vector<IdentitySample>& samples);
  /// What the file tells beyond places and ids: "cameras, kind".
  const std::string& extras() const noexcept { return extras_; }

 private:
  enum Column : std::size_t {
    kTick,
    kId,
    kX,
    kY,
    kZ,
    kCameras,
    kKind,
    kAmbiguous,
    kSd,
    kXx,
    kXy,
    kXz,
    kYy,
    kYz,
    kZz,
    kColumns
  };
  void read_header();
  void advance();
  std::uint32_t camera_set() const;
  Eigen::Matrix3d covariance() const;

  CsvReader csv_;
  std::uint64_t ticks_;
  std::uint32_t cameras_;
  std::array<std::optional<std::size_t>, kColumns> field_of_;
  std::size_t fields_ = 0;
  std::string extras_;
  std::optional<std::uint64_t> tick_;  // of sample_; none: the file has ended
  IdentitySample sample_;
};

}  // namespace glint::identity
