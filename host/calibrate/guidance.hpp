// SPDX-License-Identifier: MIT
// What to say to the person who moves the target: how much is there, what is missing, whether it is enough.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/calibrate/coverage.hpp"
#include "host/calibrate/samples.hpp"
#include "host/geometry/camera.hpp"

namespace glint {

/// How much is wanted. The numbers are for ticks in which the target has moved since the last that counted.
struct GuidanceWants {
  std::uint64_t ticks = 1000;        ///< per camera: vendors' flows ask for 1,000 to 4,000; more hardly helps
  std::uint64_t ticks_per_cell = 4;  ///< of the coverage grid: one stray reflection must not fill a cell
  double covered = 0.7;              ///< share of cells; some corners look where nobody can hold a target
  std::uint64_t common_ticks = 200;  ///< of a link between two cameras
  std::uint64_t least_ticks = 100;   ///< per camera, below which no calibration is tried
  std::uint64_t least_common_ticks =
      50;  ///< of a link, likewise: a fifth is held out, the pose of two needs many
};

/// A board gives a whole pose in every tick, and is moved slowly: a hundredth to a tenth of the ticks do.
GuidanceWants wants_for(const Target& target);

struct CameraProgress {
  std::string name;
  std::uint64_t ticks = 0;  ///< in which it saw the target somewhere new
  double covered = 0.0;     ///< share of the cells with enough; 0..1
  double progress = 0.0;    ///< 0..1; 1: this camera has all that it needs
  std::string missing;      ///< "nothing yet in the lower left of the image"; empty: all is there
};

struct GuidanceState {
  std::vector<CameraProgress> cameras;
  double progress = 0.0;               ///< of the camera that has least
  bool ready = false;                  ///< all that was wanted is there
  std::vector<std::string> blocking;   ///< why no calibration can come of this yet; empty: one can be tried
  std::vector<std::string> sentences;  ///< what to do next, most urgent first; holds those that block too
};

/// Takes sightings as they come. An add() takes about a microsecond with 4 cameras and 40 with 32, and
/// allocates only while it warms up.
class Guidance {
 public:
  /// `lenses`: one per camera where the intrinsics are known, to notice samples that all lie in one plane (in
  /// raw images the lens hides that); else empty.
  Guidance(const Target& target, std::vector<SampleCamera> cameras,
           const std::vector<CameraCalibration>& lenses = {});
  Guidance(GuidanceWants wants, std::vector<SampleCamera> cameras,
           const std::vector<CameraCalibration>& lenses = {});

  /// All sightings of one tick, by camera, then point.
  void add(std::span<const Sighting> tick);
  /// All of a recorded set.
  void add(const SampleSet& samples);

  GuidanceState state() const;
  /// One line for a terminal, without line end: each camera's share (where that takes more than half of the
  /// line, how many are ready), then the most urgent sentence. At most `columns` characters.
  std::string status_line(std::size_t columns = 100) const;

  std::uint64_t ticks() const noexcept { return ticks_; }
  const CoverageGrid& coverage(std::size_t camera) const { return seen_[camera].coverage; }
  const Overlap& overlap() const noexcept { return overlap_; }

 private:
  struct Seen {
    CoverageGrid coverage;
    std::uint64_t ticks = 0;
    std::vector<Sighting> last;  // what it saw in the last tick that counted
  };
  /// Evenly thinned pairs of undistorted points that two cameras saw at the same tick.
  struct PairPoints {
    std::uint64_t met = 0, every = 1;
    std::vector<Eigen::Vector2d> a, b;
  };

  bool moved(const Seen& camera, std::span<const Sighting> now, double least_px) const noexcept;
  void add_pair(std::span<const Sighting> a, std::span<const Sighting> b);
  bool flat(std::size_t a, std::size_t b) const;
  std::vector<std::string> plane_sentences() const;

  GuidanceWants wants_;
  std::vector<SampleCamera> cameras_;
  std::vector<Camera> lenses_;
  std::vector<Seen> seen_;
  std::vector<PairPoints> pairs_;  // a * cameras + b, a < b; empty without lenses
  Overlap overlap_;
  std::uint64_t ticks_ = 0;
  std::vector<std::span<const Sighting>> by_camera_;  // scratch of add()
  std::vector<std::uint32_t> counted_;                // likewise
};

/// Standard deviations of points along their principal axes, longest first, in metres.
Eigen::Vector3d principal_spread_m(std::span<const Eigen::Vector3d> points_in_world);
/// What is wrong with the extent of reconstructed samples ("the samples lie in one plane: ..."); empty:
/// nothing.
std::string spread_sentence(std::span<const Eigen::Vector3d> points_in_world);

}  // namespace glint
