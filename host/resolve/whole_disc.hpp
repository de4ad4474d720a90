// SPDX-License-Identifier: MIT
// Whether a blob can be the whole image of one marker and nothing else, without looking at pixels.
#pragma once

#include <Eigen/Core>

#include "host/resolve/cut_disc.hpp"
#include "host/resolve/disc_fit.hpp"
#include "shaders/interface/blob_record.h"

namespace glint {

/// What sets a blob apart from the one that was expected; 0 in all is a perfect match.
struct BlobDeviation {
  double area = 0.0;    ///< relative
  double weight = 0.0;  ///< relative
  double size = 0.0;    ///< of the mean second moment, relative
  double shape = 0.0;   ///< difference of the second moments along two axes over their sum, at most
};

class WholeDiscTest {
 public:
  explicit WholeDiscTest(const PixelNoise& noise);

  /// Where the expected disc's brightness is unknown it is taken from the blob's peak.
  BlobDeviation deviation(const shaders::BlobRecord& blob, const ExpectedDisc& expected) const noexcept;

  /// Fewer than 1 in 1000 whole, unclipped markers are refused (decision 0021). A blob that touches the
  /// border of the image, or is clipped, is never taken for whole: its centroid does not say where the marker
  /// is as well as its pixels do.
  bool may_be_whole(const shaders::BlobRecord& blob, const ExpectedDisc& expected,
                    const NoiseExcess& excess = {}) const noexcept;

  /// Brightness of the expected disc, going by the blob's peak.
  double grey(const shaders::BlobRecord& blob, const ExpectedDisc& expected) const noexcept;
  /// Radius of the round disc that would have this second moment, along each axis, above the limit.
  double radius_px(const shaders::BlobRecord& blob, double second_moment_px2) const noexcept;

 private:
  double grey_of(const shaders::BlobRecord& blob, double radius_px) const noexcept;
  PixelNoise noise_;
  double sigma_px_;
  CutDiscs cut_discs_;
};

}  // namespace glint
