// SPDX-License-Identifier: MIT
// The truth: where markers, cameras and poles are at every tick, and who sees whom.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "host/base/pulse_code.hpp"
#include "host/geometry/camera.hpp"
#include "host/sim/faults.hpp"
#include "host/sim/movement.hpp"
#include "host/sim/obstacle.hpp"
#include "host/sim/options.hpp"
#include "host/sim/person.hpp"
#include "host/sim/sim_camera.hpp"

namespace glint {

namespace sim {

/// Where a marker's image lies in one camera over the exposure.
struct MarkerView {
  /// In front of the camera, within the lens model and not missing; the rest is valid only then.
  bool imaged = false;
  double distance_m = 0.0;
  double x_px = 0.0, y_px = 0.0;                     ///< middle of the bounding box
  double half_width_px = 0.0, half_height_px = 0.0;  ///< of the outline and its motion
  double radius_px = 0.0;                            ///< larger of the two
};

}  // namespace sim

/// One marker at the middle of one exposure. Bit c of a set is camera c.
struct MarkerTruth {
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_in_world = Eigen::Vector3d::Zero();
  /// Its whole image, motion included, is at least 2 px inside the frame, and nothing hides more than 20 % of
  /// it.
  std::uint32_t visible = 0;
  /// Visible, the frame arrived in its set, and its blob stands alone: 4 px or more between its outline and
  /// that of any other imaged marker, of any static bright spot and of any blink. This is "seen".
  std::uint32_t clean = 0;
};

struct TickTruth {
  std::uint64_t tick = 0;
  std::uint32_t delivered = 0;  ///< cameras whose frame of this tick arrives in its set
  std::vector<MarkerTruth> markers;
  std::vector<sim::MarkerView> views;  ///< index: camera * markers + marker
  std::vector<Pose> world_from_body;   ///< of every rigid body, at mid exposure

  std::span<const sim::MarkerView> views_of(std::uint32_t camera) const noexcept {
    return std::span(views).subspan(camera * markers.size(), markers.size());
  }
};

namespace sim {

/// A static reflection: a disc through the optical blur.
struct BrightSpot {
  double x_px = 0.0, y_px = 0.0, radius_px = 0.0, grey = 0.0;
};

/// Stray ambient light: a wide glow around one place of the image.
struct Glow {
  double x_px = 0.0, y_px = 0.0, width_px = 1.0;
  double grey_at(double at_x_px, double at_y_px) const noexcept {
    constexpr double kMost_grey = 4.0;  // with the black level of 8 that is 8 to 12 grey, as in a dark room
    const double dx = (at_x_px - x_px) / width_px, dy = (at_y_px - y_px) / width_px;
    return kMost_grey / (1.0 + 6.0 * (dx * dx + dy * dy));
  }
};

}  // namespace sim

/// Everything of a simulated run follows from its options. Reentrant: any thread may ask for any tick.
class Scene {
 public:
  /// Throws Error listing what is wrong with the options.
  explicit Scene(const SimOptions& options);

  const SimOptions& options() const noexcept { return options_; }
  /// What a calibration would have found before anything was bumped; exact.
  const Calibration& calibration() const noexcept { return calibration_; }
  std::uint32_t cameras() const noexcept { return options_.cameras; }
  std::uint32_t markers() const noexcept { return options_.markers; }

  /// Of a camera that is on time: what time stamps say, and what the truth is about.
  double mid_exposure_s(std::uint64_t tick) const noexcept {
    return static_cast<double>(tick) / options_.rate_hz;
  }
  /// When that camera really exposes.
  double mid_exposure_s(std::uint32_t camera, std::uint64_t tick) const noexcept;
  sim::MarkerState marker(std::uint32_t marker, double time_s) const noexcept {
    return movement_->marker(marker, time_s);
  }
  /// The same without velocity, for less.
  Eigen::Vector3d position(std::uint32_t marker, double time_s) const noexcept {
    return movement_->position(marker, time_s);
  }
  /// Rigid bodies in the scene; none unless the motion has them.
  std::uint32_t bodies() const noexcept { return movement_->bodies(); }
  /// Where the markers sit in the frame of their body, in order of their numbers.
  std::vector<Eigen::Vector3d> body_markers(std::uint32_t body) const;
  std::optional<std::uint32_t> body_of(std::uint32_t marker) const noexcept;
  /// The light is off in that pulse.
  bool dark(std::uint64_t tick) const noexcept { return code_ && code_->dark(tick + options_.code_first); }
  /// Replaces `truth`; allocates only the first time.
  void truth(std::uint64_t tick, TickTruth& truth) const;

  /// Which camera of the calibration takes the frames that come as those of `camera`: itself unless two were
  /// swapped.
  std::uint32_t behind(std::uint32_t camera, std::uint64_t tick) const noexcept;
  /// What takes the frames that come as those of `camera`, as it really stands at that tick.
  const sim::SimCamera& camera(std::uint32_t camera, std::uint64_t tick) const noexcept;
  /// Spots and glow belong to a place: ask for behind() what a frame shows.
  std::span<const sim::BrightSpot> spots(std::uint32_t camera) const noexcept { return spots_[camera]; }
  const sim::Glow& glow(std::uint32_t camera) const noexcept { return glows_[camera]; }
  std::span<const sim::Pole> poles() const noexcept { return poles_; }
  /// Views of all markers in one camera; `views` has one place per marker.
  void views(std::uint32_t camera, std::uint64_t tick, std::span<sim::MarkerView> views) const noexcept;
  /// Whether anything could hide part of that marker.
  bool may_be_hidden(std::uint32_t camera, std::uint64_t tick, std::uint32_t marker,
                     std::span<const sim::MarkerView> views) const noexcept;
  /// Calls visit(point_in_camera, hidden) for `count` points spread evenly over the marker's visible disc;
  /// kMostSamples at most.
  template <typename Visit>
  void sample_disc(std::uint32_t camera, std::uint64_t tick, std::uint32_t marker, double time_s,
                   std::span<const sim::MarkerView> views, unsigned count, Visit&& visit) const {
    std::array<DiscSample, kMostSamples> samples;
    const std::span<DiscSample> wanted(samples.data(), std::min<std::size_t>(count, kMostSamples));
    fill_samples(camera, tick, marker, time_s, views, wanted);
    for (const DiscSample& sample : wanted) visit(sample.point_in_camera, sample.hidden);
  }
  static constexpr std::size_t kMostSamples = 400;

 private:
  struct DiscSample {
    Eigen::Vector3d point_in_camera;
    bool hidden;
  };
  /// Only of a scene with a wand.
  Eigen::Vector3d wand_middle(double time_s) const noexcept {
    return 0.5 * (position(0, time_s) + position(options_.markers - 1, time_s));
  }
  void fill_samples(std::uint32_t camera, std::uint64_t tick, std::uint32_t marker, double time_s,
                    std::span<const sim::MarkerView> views, std::span<DiscSample> samples) const noexcept;
  bool stands_alone(std::uint32_t camera, std::uint64_t tick, std::uint32_t marker,
                    std::span<const sim::MarkerView> views) const noexcept;

  SimOptions options_;
  Calibration calibration_;
  std::optional<PulseCode> code_;
  std::unique_ptr<const sim::Movement> movement_;
  std::optional<sim::Person> person_;
  std::vector<sim::SimCamera> cameras_;
  std::vector<sim::SimCamera> bumped_;  // none or one
  std::vector<std::vector<sim::BrightSpot>> spots_;
  std::vector<sim::Glow> glows_;
  std::vector<sim::Pole> poles_;
};

}  // namespace glint
