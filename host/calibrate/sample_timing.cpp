// SPDX-License-Identifier: MIT
#include "host/calibrate/sample_timing.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <Eigen/Dense>

#include "host/calibrate/sighting_model.hpp"
#include "host/geometry/triangulate.hpp"

namespace glint {
namespace {

constexpr std::uint64_t kFewestSightings = 200;
constexpr double kLeastDelay_s = 0.0005;  // less than that is within what cameras of one model do
constexpr double kLeastJitter_s = 0.001;
constexpr double kClearly = 4.0;           // standard deviations
constexpr double kLeastSpeed_px_s = 20.0;  // slower images tell nothing of time

/// One sighting of a point that is known before, at and after its tick.
struct MovingSighting {
  std::uint32_t camera = 0;
  Eigen::Vector2d residual_px, velocity_px_s;
  Eigen::Matrix<double, 2, 3> by_point;
};

class Timing {
 public:
  Timing(const Calibration& calibration, const SampleSet& samples)
      : samples_(samples),
        cameras_(calibration.cameras.begin(), calibration.cameras.end()),
        ticks_(ticks_of(samples)),
        count_(static_cast<Eigen::Index>(cameras_.size())),
        normal_(Eigen::MatrixXd::Zero(count_, count_)),
        right_(Eigen::VectorXd::Zero(count_)) {
    for (const CameraCalibration& camera : calibration.cameras) intrinsics_.push_back(intrinsics_of(camera));
  }

  std::optional<SampleTiming> run() {
    if (!(samples_.rate_hz > 0.0)) return std::nullopt;
    place_points();
    for (std::size_t t = 1; t + 1 < ticks_.size(); ++t) {
      if (ticks_[t - 1].tick + 1 != ticks_[t].tick || ticks_[t].tick + 1 != ticks_[t + 1].tick) continue;
      for (std::uint32_t point = 0; point < samples_.target.points_in_target.size(); ++point)
        add_point(t, point);
    }
    if (used_ < kFewestSightings) return std::nullopt;
    return solve();
  }

 private:
  using Places = std::vector<std::optional<Eigen::Vector3d>>;  // in the world, by point

  void place_points() {
    for (const SampleTick& tick : ticks_) {
      Places places(samples_.target.points_in_target.size());
      for (std::uint32_t point = 0; point < places.size(); ++point) {
        std::vector<Observation> views;
        for (const Sighting& s : tick.sightings) {
          if (s.point != point) continue;
          if (const auto plane = cameras_[s.camera].undistort(s.pixel))
            views.push_back({&cameras_[s.camera], *plane, Eigen::Matrix2d::Identity()});
        }
        TriangulateOptions options;
        options.marker_radius_m = samples_.target.marker_radius_m;
        if (const auto found = triangulate(views, options)) places[point] = found->position_in_world;
      }
      places_.push_back(std::move(places));
    }
  }

  void add_point(std::size_t t, std::uint32_t point) {
    const auto &before = places_[t - 1][point], &here = places_[t][point], &after = places_[t + 1][point];
    if (!before || !here || !after) return;
    // The ends of a wand of two may have been numbered the other way round meanwhile: that is a jump, not a
    // motion.
    if ((*after - *here - (*here - *before)).norm() > 0.5 * (*after - *before).norm()) return;
    const Eigen::Vector3d velocity = (*after - *before) * (0.5 * samples_.rate_hz);
    std::vector<MovingSighting> views;
    for (const Sighting& s : ticks_[t].sightings) {
      if (s.point != point) continue;
      PredictedSighting predicted;
      if (!predict_sighting(intrinsics_[s.camera].data(), cameras_[s.camera].in_camera(*here),
                            samples_.target.marker_radius_m, predicted))
        continue;
      const Eigen::Matrix<double, 2, 3> by_point =
          predicted.by_point_in_camera * cameras_[s.camera].camera_from_world_rotation();
      views.push_back({s.camera, s.pixel - predicted.pixel, by_point * velocity, by_point});
    }
    if (views.size() >= 2) add_views(views);
  }

  void add_views(const std::vector<MovingSighting>& views) {
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    double speed = 0.0;
    for (const MovingSighting& view : views) {
      information += view.by_point.transpose() * view.by_point;
      speed = std::max(speed, view.velocity_px_s.norm());
    }
    if (speed < kLeastSpeed_px_s) return;
    const Eigen::Matrix3d covariance = information.inverse();
    if (!covariance.allFinite()) return;
    for (const MovingSighting& view : views) {
      Eigen::Matrix<double, 2, Eigen::Dynamic> by_delay =
          Eigen::Matrix<double, 2, Eigen::Dynamic>::Zero(2, count_);
      by_delay.col(view.camera) += view.velocity_px_s;
      for (const MovingSighting& other : views)
        by_delay.col(other.camera) -=
            view.by_point * covariance * other.by_point.transpose() * other.velocity_px_s;
      normal_ += by_delay.transpose() * by_delay;
      right_ += by_delay.transpose() * view.residual_px;
      rows_.push_back({by_delay, view.residual_px});
      ++used_;
    }
  }

  SampleTiming solve() const {
    // All cameras late alike changes nothing: their mean is zero. So is what nothing is known of.
    Eigen::MatrixXd bordered = Eigen::MatrixXd::Zero(count_ + 1, count_ + 1);
    bordered.topLeftCorner(count_, count_) = normal_;
    const double scale = std::max(1e-9, normal_.diagonal().maxCoeff());
    bordered.topRightCorner(count_, 1).setConstant(scale);
    bordered.bottomLeftCorner(1, count_).setConstant(scale);
    const Eigen::MatrixXd inverse =
        bordered.completeOrthogonalDecomposition().pseudoInverse().topLeftCorner(count_, count_);
    const Eigen::VectorXd delays = inverse * right_;

    // |r|^2 of what is left against how strongly it would feel independent moments: an offset and a slope.
    double n = 0.0, sx = 0.0, sy = 0.0, sxx = 0.0, sxy = 0.0, syy = 0.0;
    for (const Row& row : rows_) {
      const double x = row.by_delay.squaredNorm(),
                   y = (row.residual_px - row.by_delay * delays).squaredNorm();
      n += 1.0, sx += x, sy += y, sxx += x * x, sxy += x * y, syy += y * y;
    }
    const double spread = sxx - sx * sx / n;
    const double slope = spread > 0.0 ? (sxy - sx * sy / n) / spread : 0.0;
    const double rest = std::max(0.0, (syy - sy * sy / n - slope * slope * spread) / std::max(1.0, n - 2.0));
    SampleTiming timing;
    timing.sightings = used_;
    timing.jitter_s = std::sqrt(std::max(0.0, slope));
    // Neighbouring sightings share their errors: five of them count as one.
    constexpr double kShared = 5.0;
    const double slope_sd = spread > 0.0 ? std::sqrt(kShared * rest / spread) : 0.0;
    timing.jitter_sd_s = timing.jitter_s > 0.0 ? 0.5 * slope_sd / timing.jitter_s : 0.0;
    const double variance_px2 = sy / (2.0 * n);
    for (Eigen::Index c = 0; c < count_; ++c)
      timing.cameras.push_back({delays[c], std::sqrt(std::max(0.0, kShared * variance_px2 * inverse(c, c)))});
    return timing;
  }

  struct Row {
    Eigen::Matrix<double, 2, Eigen::Dynamic> by_delay;
    Eigen::Vector2d residual_px;
  };

  const SampleSet& samples_;
  std::vector<Camera> cameras_;
  std::vector<Intrinsics> intrinsics_;
  std::vector<SampleTick> ticks_;
  std::vector<Places> places_;
  Eigen::Index count_;
  Eigen::MatrixXd normal_;
  Eigen::VectorXd right_;
  std::vector<Row> rows_;
  std::uint64_t used_ = 0;
};

std::string milliseconds(double seconds) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f ms", 1e3 * seconds);
  return text;
}

}  // namespace

std::optional<SampleTiming> timing_of(const Calibration& calibration, const SampleSet& samples) {
  return Timing(calibration, samples).run();
}

std::vector<std::string> timing_sentences(const SampleTiming& timing, const Calibration& calibration) {
  std::vector<std::string> sentences;
  if (timing.jitter_s > kLeastJitter_s && timing.jitter_s > kClearly * timing.jitter_sd_s) {
    sentences.push_back(
        "the cameras are not synchronised: within a tick their moments differ by " +
        milliseconds(timing.jitter_s) +
        " rms, so that whatever moves is seen at different places. Use a hardware trigger, or move the "
        "target slowly and hold it still");
  }
  // One late camera makes the mean of all late, but not their median. Of two cameras the later one is named.
  std::vector<double> sorted;
  for (const CameraTiming& camera : timing.cameras) sorted.push_back(camera.delay_s);
  std::sort(sorted.begin(), sorted.end());
  const double usual_s = sorted.empty() ? 0.0 : sorted[(sorted.size() - 1) / 2];
  for (std::size_t c = 0; c < timing.cameras.size(); ++c) {
    const double delay_s = timing.cameras[c].delay_s - usual_s;
    if (std::abs(delay_s) < std::max(kLeastDelay_s, kClearly * timing.cameras[c].delay_sd_s)) continue;
    sentences.push_back("the images of " + calibration.cameras[c].name + " are " +
                        milliseconds(std::abs(delay_s)) + (delay_s > 0.0 ? " later" : " earlier") +
                        " than those of the others on average");
  }
  return sentences;
}

}  // namespace glint
