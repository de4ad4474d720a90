// SPDX-License-Identifier: MIT
// Rigid alignment of measured markers with where they should be, and what to say if that makes no sense.
#include "host/calibrate/ground.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>

#include <Eigen/Geometry>

#include "host/base/check.hpp"
#include "host/base/error.hpp"

namespace glint {
namespace {

constexpr std::size_t kMostPoints = 12;  // 11,880 ways to pick four
constexpr double kFits_m = 0.005;        // rms: an L-frame is built to a millimetre, and triangulated better
constexpr double kClearly = 3.0;         // the next best choice of markers must fit that much worse
constexpr double kNoise_m = 0.0005;      // below this, which of two fits is better is chance
constexpr double kLeastSine = 0.05;      // of the angle at the origin, 3 degrees
constexpr double kLeastDistance_m = 0.001;

std::string metres(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3f m", value);
  return text.data();
}

/// All distances between points, in rising order, for a message.
std::string distances_of(std::span<const Eigen::Vector3d> points) {
  std::vector<double> all;
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = i + 1; j < points.size(); ++j) all.push_back((points[i] - points[j]).norm());
  std::sort(all.begin(), all.end());
  std::string text;
  for (std::size_t i = 0; i < std::min<std::size_t>(all.size(), 10); ++i)
    text += (i > 0 ? ", " : "") + metres(all[i]);
  return all.size() > 10 ? text + ", ..." : text;
}

struct Fit {
  Pose a_from_b;
  double rms_m = std::numeric_limits<double>::infinity();
};

/// Least squares without scale (Umeyama, PAMI 13(4), 1991).
Fit align(const Eigen::Matrix3Xd& in_a, const Eigen::Matrix3Xd& in_b) {
  const Eigen::Matrix4d m = Eigen::umeyama(in_b, in_a, false);
  Fit fit;
  fit.a_from_b = {Eigen::Quaterniond(Eigen::Matrix3d(m.topLeftCorner<3, 3>())).normalized(),
                  m.topRightCorner<3, 1>()};
  double squares = 0.0;
  for (Eigen::Index i = 0; i < in_a.cols(); ++i)
    squares += (fit.a_from_b * in_b.col(i) - in_a.col(i)).squaredNorm();
  fit.rms_m = std::sqrt(squares / static_cast<double>(in_a.cols()));
  return fit;
}

/// Tries every ordered choice of points for the markers of a frame.
class FrameSearch {
 public:
  FrameSearch(std::span<const Eigen::Vector3d> points, Eigen::Matrix3Xd wanted)
      : points_(points),
        wanted_(std::move(wanted)),
        chosen_(3, wanted_.cols()),
        used_(points.size(), false) {}

  void run() { choose(0); }
  const Fit& best() const { return best_; }
  const Fit& next() const { return next_; }

 private:
  void choose(Eigen::Index marker) {
    if (marker == wanted_.cols()) {
      const Fit fit = align(wanted_, chosen_);
      if (fit.rms_m < best_.rms_m) {
        next_ = best_;
        best_ = fit;
      } else if (fit.rms_m < next_.rms_m) {
        next_ = fit;
      }
      return;
    }
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (used_[i]) continue;
      chosen_.col(marker) = points_[i];
      // A wrong distance to the corner's marker cannot be mended by the others.
      const double off =
          marker == 0 ? 0.0 : (chosen_.col(marker) - chosen_.col(0)).norm() - wanted_.col(marker).norm();
      if (std::abs(off) > 4.0 * kFits_m) continue;
      used_[i] = true;
      choose(marker + 1);
      used_[i] = false;
    }
  }

  std::span<const Eigen::Vector3d> points_;
  Eigen::Matrix3Xd wanted_, chosen_;
  std::vector<bool> used_;
  Fit best_, next_;
};

/// Refuses a world below whose floor most cameras stand; notes single ones.
void check_above(Ground& ground, const Calibration& calibration, const std::string& what_to_do) {
  std::size_t below = 0;
  for (const CameraCalibration& camera : calibration.cameras) {
    const double height_m = (ground.new_world_from_world * camera.world_from_camera.translation).z();
    if (height_m >= 0) continue;
    ++below;
    ground.notes.push_back(camera.name + " stands " + metres(-height_m) + " below the floor");
  }
  if (2 * below > calibration.cameras.size())
    throw Error("the cameras would look from below the floor: " + what_to_do);
}

/// z axis given; x as near to `x_hint` as it can be.
Pose axes_at(const Eigen::Vector3d& origin, const Eigen::Vector3d& x_hint, const Eigen::Vector3d& z) {
  Eigen::Matrix3d world_from_new;
  world_from_new.col(2) = z.normalized();
  world_from_new.col(0) = (x_hint - x_hint.dot(world_from_new.col(2)) * world_from_new.col(2)).normalized();
  world_from_new.col(1) = world_from_new.col(2).cross(world_from_new.col(0));
  return Pose{Eigen::Quaterniond(world_from_new).normalized(), origin}.inverse();
}

void check_height(double height_m, const char* what) {
  if (!std::isfinite(height_m) || std::abs(height_m) > 10.0)
    throw Error(std::string(what) + " must be given in metres, at most 10");
}

}  // namespace

Ground ground_from_l_frame(std::span<const Eigen::Vector3d> points_in_world, const LFrame& frame,
                           const Calibration& calibration) {
  check_height(frame.marker_height_m, "the height of the L-frame's markers");
  if (frame.x_arm_m.empty() || frame.y_arm_m.empty())
    throw Error("an L-frame has at least one marker on each arm, besides that at the corner");
  const auto count = static_cast<Eigen::Index>(1 + frame.x_arm_m.size() + frame.y_arm_m.size());
  Eigen::Matrix3Xd wanted = Eigen::Matrix3Xd::Constant(3, count, 0.0);
  Eigen::Index next = 1;
  for (const double place : frame.x_arm_m) wanted(0, next++) = place;
  for (const double place : frame.y_arm_m) wanted(1, next++) = place;
  for (Eigen::Index i = 1; i < count; ++i)
    if (!(wanted.col(i).norm() >= 0.01 && wanted.col(i).norm() <= 10.0))
      throw Error("the arms of an L-frame are between 0.01 m and 10 m long; is one given in millimetres?");
  if (points_in_world.size() < static_cast<std::size_t>(count)) {
    throw Error("only " + std::to_string(points_in_world.size()) + " of the L-frame's " +
                std::to_string(count) +
                " markers were found: put it where at least two cameras see all of it");
  }
  if (points_in_world.size() > kMostPoints) {
    throw Error(std::to_string(points_in_world.size()) + " points were found where the L-frame has " +
                std::to_string(count) + ": take other markers away and mask reflections");
  }

  FrameSearch search(points_in_world, wanted);
  search.run();
  const Fit& best = search.best();
  if (!(best.rms_m <= kFits_m)) {
    throw Error("no points fit the L-frame; distances between those found: " + distances_of(points_in_world) +
                ": measure its arms from marker centre to marker centre, and keep other markers away");
  }
  if (search.next().rms_m < kClearly * std::max(best.rms_m, kNoise_m)) {
    throw Error("the L-frame's markers cannot be told apart: its arms must differ by at least " +
                metres(2.0 * kClearly * std::max(best.rms_m, kNoise_m)) + " in length");
  }
  Ground ground;
  ground.new_world_from_world = best.a_from_b;
  ground.new_world_from_world.translation.z() += frame.marker_height_m;
  ground.fit_rms_m = best.rms_m;
  check_above(ground, calibration,
              "turn the L-frame over, or swap the lengths of its x and y arms (seen from above, y is a "
              "quarter turn to "
              "the left of x)");
  return ground;
}

Ground ground_from_markers(const Eigen::Vector3d& origin, const Eigen::Vector3d& on_x,
                           const Eigen::Vector3d& in_xy, double marker_height_m,
                           const Calibration& calibration) {
  check_height(marker_height_m, "the height of the markers");
  const Eigen::Vector3d x = on_x - origin, z = x.cross(in_xy - origin);
  if (!(x.norm() > kLeastDistance_m) || !((in_xy - origin).norm() > kLeastDistance_m))
    throw Error("two of the three markers for the ground are at the same place");
  if (!(z.norm() > kLeastSine * x.norm() * (in_xy - origin).norm()))
    throw Error(
        "the three markers for the ground are nearly on one line: move the third to the side, along y");
  Ground ground;
  ground.new_world_from_world = axes_at(origin, x, z);
  ground.new_world_from_world.translation.z() += marker_height_m;
  check_above(
      ground, calibration,
      "the third marker must lie to the left of the line from the first to the second, seen from above");
  return ground;
}

Ground ground_from_board(const Pose& world_from_board, double thickness_m, const Calibration& calibration) {
  check_height(thickness_m, "the thickness of the board");
  Eigen::Vector3d z = world_from_board.rotation * Eigen::Vector3d::UnitZ();
  std::size_t above = 0;
  for (const CameraCalibration& camera : calibration.cameras)
    if (z.dot(camera.world_from_camera.translation - world_from_board.translation) > 0) ++above;
  if (2 * above < calibration.cameras.size()) z = -z;
  Ground ground;
  ground.new_world_from_world =
      axes_at(world_from_board.translation, world_from_board.rotation * Eigen::Vector3d::UnitX(), z);
  ground.new_world_from_world.translation.z() += thickness_m;
  check_above(ground, calibration, "lay the board on the floor, its printed side up");
  return ground;
}

Pose provisional_world_from_world(const Calibration& calibration,
                                  std::span<const Eigen::Vector3d> points_in_world) {
  if (calibration.cameras.empty()) return {};
  Eigen::Vector3d up = Eigen::Vector3d::Zero(), middle = Eigen::Vector3d::Zero();
  for (const CameraCalibration& camera : calibration.cameras) {
    up -= camera.world_from_camera.rotation * Eigen::Vector3d::UnitY();
    middle += camera.world_from_camera.translation / static_cast<double>(calibration.cameras.size());
  }
  const Eigen::Quaterniond& first = calibration.cameras.front().world_from_camera.rotation;
  // Cameras mounted all ways round have no common up: the first one's then.
  if (up.norm() < 0.2 * static_cast<double>(calibration.cameras.size()))
    up = first * -Eigen::Vector3d::UnitY();
  Eigen::Vector3d right = first * Eigen::Vector3d::UnitX();
  if (right.cross(up.normalized()).norm() < kLeastSine) right = first * Eigen::Vector3d::UnitZ();
  if (points_in_world.empty()) return axes_at(middle, right, up);

  middle.setZero();
  for (const Eigen::Vector3d& p : points_in_world) middle += p / static_cast<double>(points_in_world.size());
  std::vector<double> heights;
  for (const Eigen::Vector3d& p : points_in_world) heights.push_back((p - middle).dot(up.normalized()));
  const auto low =
      heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 100);  // but for stray points
  std::nth_element(heights.begin(), low, heights.end());
  return axes_at(middle + *low * up.normalized(), right, up);
}

double scale_for_distance(const Eigen::Vector3d& a_in_world, const Eigen::Vector3d& b_in_world,
                          double true_m) {
  const double measured_m = (a_in_world - b_in_world).norm();
  if (!(measured_m > kLeastDistance_m))
    throw Error("the two points of the known distance are at the same place");
  if (!(true_m > kLeastDistance_m) || !std::isfinite(true_m))
    throw Error("the known distance must be given in metres and be more than a millimetre");
  return true_m / measured_m;
}

void transform(Calibration& calibration, const Pose& new_world_from_world, double scale) {
  GLINT_CHECK(scale > 0 && std::isfinite(scale));
  for (CameraCalibration& camera : calibration.cameras) {
    camera.world_from_camera.translation *= scale;
    camera.world_from_camera = new_world_from_world * camera.world_from_camera;
  }
}

void transform(CalibrationUncertainty& uncertainty, const Calibration& transformed,
               const Pose& new_world_from_world, double scale) {
  const Eigen::Index size = uncertainty.covariance.rows(), block = uncertainty.intrinsics ? 15 : 6;
  if (size == 0) return;
  GLINT_CHECK(size == block * static_cast<Eigen::Index>(transformed.cameras.size()));
  // With R, t of camera_from_new_world and T the shift, t = scale * t_old - R T: so when R turns by w and
  // t_old moves by d, t moves by scale * d - w x (R T).
  Eigen::MatrixXd change = Eigen::MatrixXd::Identity(size, size);
  for (std::size_t i = 0; i < transformed.cameras.size(); ++i) {
    const Eigen::Index at = static_cast<Eigen::Index>(i) * block;
    const Eigen::Vector3d v =
        transformed.cameras[i].world_from_camera.rotation.conjugate() * new_world_from_world.translation;
    change.block<3, 3>(at + 3, at) << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
    change.block<3, 3>(at + 3, at + 3) *= scale;
  }
  uncertainty.covariance = change * uncertainty.covariance * change.transpose();
}

}  // namespace glint
