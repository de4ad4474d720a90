// SPDX-License-Identifier: MIT
// What was seen of a target while it was moved through the volume: all that a calibration is computed from.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/target/target.hpp"

namespace glint {

/// One point of the target in one image.
struct Sighting {
  std::uint64_t tick = 0;                           ///< number of the exposure: the same in all cameras
  std::uint32_t camera = 0;                         ///< index into SampleSet::cameras
  std::uint32_t point = 0;                          ///< index into Target::points_in_target
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< raw image, not undistorted
};

struct SampleCamera {
  std::string name;
  std::uint32_t width_px = 0, height_px = 0;
};

struct SampleSet {
  Target target;
  std::vector<SampleCamera> cameras;
  double rate_hz = 0.0;             ///< ticks per second; 0: unknown or not even
  std::vector<Sighting> sightings;  ///< by tick, then camera, then point; each at most once
};

/// All sightings of one tick.
struct SampleTick {
  std::uint64_t tick = 0;
  std::span<const Sighting> sightings;
};
std::vector<SampleTick> ticks_of(const SampleSet& samples);

/// Sorts; of a point seen twice by a camera at a tick, keeps neither.
void put_in_order(SampleSet& samples);

/// Which ticks are kept back to judge a calibration that did not see them: every fifth block of neighbouring
/// ticks, since neighbours are nearly the same sample. Follows from the ticks alone.
bool held_out(std::uint64_t tick_index);

/// Reads and writes JSON lines: a header with the target and the cameras, then [tick, camera, point, x_px,
/// y_px]. Numbers come back bit for bit. Throw Error naming file and line; numbers that are not finite are
/// refused, and so is an existing file unless `force`.
SampleSet read_samples(const std::filesystem::path& path);
void write_samples(const std::filesystem::path& path, const SampleSet& samples, bool force);

}  // namespace glint
