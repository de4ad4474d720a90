// SPDX-License-Identifier: MIT
// Which blobs of an image are the wand's markers, or the marker.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "host/geometry/camera.hpp"
#include "host/target/target.hpp"
#include "shaders/interface/blob_record.h"

namespace glint {

struct FoundMarker {
  std::uint32_t point = 0;                          ///< index into Target::points_in_target
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< raw image
};

/// How often, of all images.
struct WandFinderCounters {
  std::uint64_t images = 0, found = 0;
  std::uint64_t too_few = 0;    ///< fewer usable blobs than the target has markers
  std::uint64_t no_match = 0;   ///< enough blobs, but none arranged like the wand, or other ones beside a
                                ///< marker or a wand of two, which nothing tells apart from them
  std::uint64_t ambiguous = 0;  ///< more than one reading
};

/// Of one camera. A wand of three is known by its markers lying on a line at its spacings, which also tells
/// its ends apart; of a wand of two the ends look alike and are numbered as they come.
class WandFinder {
 public:
  /// Lens from `camera`; its pose is not looked at.
  WandFinder(const Target& target, const CameraCalibration& camera);

  /// All markers of the target, or none. Blobs cut off by the border are not used.
  std::vector<FoundMarker> find(std::span<const shaders::BlobRecord> blobs);
  const WandFinderCounters& counters() const noexcept { return counters_; }

 private:
  struct Candidate {
    Eigen::Vector2d pixel, plane;
  };
  std::vector<FoundMarker> find_three(const std::vector<Candidate>& candidates);
  double misfit(const Candidate& first, const Candidate& middle, const Candidate& last) const;

  Target target_;
  Camera camera_;
  WandFinderCounters counters_;
};

}  // namespace glint
