// SPDX-License-Identifier: MIT
// A closer look at blobs that tracks expect to be more, or less, than one marker.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "gpu/detector.hpp"
#include "host/match/blob_table.hpp"
#include "host/match/expected_views.hpp"
#include "host/match/prediction.hpp"
#include "host/match/usual_brightness.hpp"
#include "host/resolve/disc_fit.hpp"
#include "host/resolve/whole_disc.hpp"

namespace glint {

/// Needs the markers' radius. Keeps its memory.
class PixelLook {
 public:
  /// All borrowed for the life of this; the table is changed by look(), before which `expected` is filled
  /// with the same predictions.
  PixelLook(std::span<const Camera> cameras, const MatchOptions& options, BlobTable& table,
            const ExpectedViews& expected);

  /// Blobs in which tracks expect several markers, those that do not look like the one that is expected, and
  /// those that nobody expects and that look like two are replaced by discs fitted to their pixels.
  void look(std::span<const std::span<const shaders::BlobRecord>> records,
            std::span<const gpu::ImageView> images, std::span<const Prediction> predictions,
            MatchCounters& counters);

  /// Whether a blob that nobody expected shows all the light of a marker at this place; true if it is not
  /// known how much that is.
  bool shows_whole(std::uint32_t camera, const shaders::BlobRecord& record,
                   const Eigen::Vector3d& position_in_world) const noexcept;

 private:
  struct Wish {
    std::uint32_t blob;
    ExpectedDisc disc;
    double brightness;  ///< see Prediction
  };
  struct Look {  // wishes_[first, first + count) are of one blob
    std::uint32_t camera, first, count;
  };
  void collect(std::uint32_t camera, std::span<const shaders::BlobRecord> records,
               std::span<const Prediction> predictions);
  bool needs_look(std::uint32_t camera, const shaders::BlobRecord& record, std::span<const Wish> wishes);
  double light_of(std::uint32_t camera, double grey, const ExpectedDisc& disc) const noexcept;
  void learn_noise(std::uint32_t camera, const FitQuality& quality) noexcept;
  void resolve(std::uint32_t camera, const shaders::BlobRecord& record, const gpu::ImageView& image,
               std::span<const Wish> wishes, MatchCounters& counters);
  bool fit_stranger(std::uint32_t camera, const shaders::BlobRecord& record, const gpu::ImageView& image,
                    std::uint32_t blob, const ExpectedDisc& expected, double size_sd_px);
  bool fit_strangers(std::uint32_t camera, const shaders::BlobRecord& record, const gpu::ImageView& image,
                     std::uint32_t blob);
  bool fit(std::uint32_t camera, const shaders::BlobRecord& record, const gpu::ImageView& image,
           std::uint32_t blob, std::span<const ExpectedDisc> discs, double size_sd_px, double brightness);

  std::span<const Camera> cameras_;
  const MatchOptions& options_;
  BlobTable& table_;
  const ExpectedViews& expected_;
  DiscFit fit_;
  WholeDiscTest whole_;
  std::vector<NoiseExcess> noise_excess_;  // by camera: see learn_noise()
  std::vector<UsualBrightness> usual_;     // by camera
  std::vector<Wish> wishes_;
  std::vector<Look> needed_, welcome_;
  std::vector<std::uint32_t> unexpected_;  // blobs that no track expects and that are too long for one marker
  std::size_t turn_ = 0;                   // who comes first of those that are welcome
};

}  // namespace glint
