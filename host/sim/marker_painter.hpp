// SPDX-License-Identifier: MIT
// The noiseless image of one marker: sphere, lens, brightness, motion and blur.
#pragma once

#include <span>
#include <vector>

#include "host/sim/blur.hpp"
#include "host/sim/scene.hpp"

namespace glint::sim {

/// Grey levels that a marker's disc adds at that distance, for the exposure given: ring light falling off
/// with the square of the distance, returned by glass beads that favour small observation angles. See
/// docs/simulated-rig.md.
double marker_grey(double distance_m, double exposure_s) noexcept;

/// Paints markers one at a time into its patch. Thread-bound; allocates only for a marker larger than any
/// before.
class MarkerPainter {
 public:
  explicit MarkerPainter(const Scene& scene);

  /// The image of `marker` in `camera`; the patch is clipped to the frame and valid until the next call.
  /// Nothing if no light of it falls into the frame. With gradient: hidden parts are then taken as shown.
  const Patch* paint(std::uint32_t camera, std::uint64_t tick, std::uint32_t marker,
                     std::span<const MarkerView> views, bool with_gradient);

 private:
  void add_at(std::uint32_t camera, std::uint64_t tick, std::uint32_t marker,
              std::span<const MarkerView> views, double time_s, double share, bool partly_hidden);

  const Scene& scene_;
  BlurKernel kernel_;
  Patch patch_;
  std::vector<OutlinePoint> outline_;
};

}  // namespace glint::sim
