// SPDX-License-Identifier: MIT
// Is a detector right? Whoever is not, gets no figures.
#pragma once

#include <string>
#include <vector>

#include "gpu/detector.hpp"
#include "host/bench/scene.hpp"

namespace glint::bench {

/// Hands the limit images of the scene's first `cameras` cameras to a detector. Throws gpu::Error.
void set_limits(const Scene& scene, gpu::Detector& detector, unsigned cameras);
/// ... of all its cameras.
void set_limits(const Scene& scene, gpu::Detector& detector);

/// What the reference detector finds in a scene. Worked out once, it can judge many detectors.
class Expected {
 public:
  /// The scene must outlive it.
  explicit Expected(const Scene& scene);

  /// The first difference on any frame of the scene, for a person to read; empty if there is none. Equal
  /// must be: the number of components, areas, grey sums, weights, peaks, boxes and flags; centroids and
  /// undistorted centroids to 0.001 px; second moments to a thousandth. A detector that fails is different,
  /// too. `detector` must have the scene's limits and nothing in flight.
  ///
  /// It may have fewer cameras than the scene: then those are the scene's first ones.
  std::string difference(gpu::Detector& detector, unsigned cameras) const;
  std::string difference(gpu::Detector& detector) const {
    return difference(detector, scene_.options().cameras);
  }

  /// Components in one tick, in the first `cameras` cameras together.
  std::size_t found(unsigned tick, unsigned cameras) const noexcept;

 private:
  struct Image {
    std::vector<gpu::BlobRecord> blobs;
    std::uint32_t found = 0;
  };

  const Scene& scene_;
  std::vector<std::vector<Image>> ticks_;  // [tick][drawn camera]
};

}  // namespace glint::bench
