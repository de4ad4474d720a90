// SPDX-License-Identifier: MIT
// Which new points are markers beyond doubt: see Point::certain.
#include <gtest/gtest.h>

#include "host/match/matcher.hpp"
#include "tests/unit/match/scene.hpp"

namespace glint {
namespace {

using namespace testing;
using Eigen::Vector3d;

constexpr std::uint32_t kArea_px = 20;

struct Rig {
  explicit Rig(const Calibration& cameras) : calibration(cameras), matcher(cameras, options()) {}
  static MatchOptions options() {
    MatchOptions options;
    options.max_range_m = 10.0;
    return options;
  }
  Calibration calibration;
  Matcher matcher;
};

Rig& four_cameras() {
  static Rig rig(ring_rig(4));  // it takes a while to sum up what they see
  return rig;
}

/// Neighbours of the ring: their views cross at nearly a right angle.
Rig& two_cameras() {
  static Rig rig([] {
    Calibration calibration = ring_rig(4);
    calibration.cameras.resize(2);
    return calibration;
  }());
  return rig;
}

/// The first ones of the ring; the others are turned to where no marker is.
Rig four_of_which_look(std::size_t cameras) {
  Calibration calibration = ring_rig(4);
  for (std::size_t k = cameras; k < 4; ++k) {
    Pose& pose = calibration.cameras[k].world_from_camera;
    pose = looking_at(pose.translation, 2.0 * pose.translation);
  }
  return Rig(calibration);
}

Vector3d place_of(const Rig& rig, std::size_t camera) {
  return rig.calibration.cameras[camera].world_from_camera.translation;
}

class Certain : public ::testing::Test {
 protected:
  /// Markers as the cameras of `shown_by` show them; the others show nothing.
  const std::vector<Point>& match(Rig& rig, const std::vector<Vector3d>& markers,
                                  std::uint32_t shown_by = 0xff, std::uint32_t area_px = kArea_px,
                                  std::span<const Prediction> predictions = {}) {
    Exposure exposure = expose(rig.calibration, markers, {.centroid_px = 0.02}, random_);
    for (std::size_t camera = 0; camera < exposure.blobs.size(); ++camera) {
      if ((shown_by >> camera & 1u) == 0) exposure.blobs[camera].clear();
      for (shaders::BlobRecord& blob : exposure.blobs[camera]) blob.area_px = area_px;
    }
    MatchCounters counters;
    rig.matcher.match(exposure.spans(), predictions, points_, counters);
    return points_;
  }

  const std::vector<Vector3d> apart_{{0.5, 0.4, 0.3}, {-0.4, 0.1, 0.8}, {0.1, -0.6, 1.3}};
  std::mt19937_64 random_{61};
  std::vector<Point> points_;
};

TEST_F(Certain, MarkersWellApartAreSoForTwoCameras) {
  for (int frame = 0; frame < 50; ++frame) {
    ASSERT_EQ(match(two_cameras(), apart_).size(), apart_.size());
    for (const Point& point : points_) {
      EXPECT_EQ(point.views, 2u);
      EXPECT_TRUE(point.certain);
    }
  }
}

TEST_F(Certain, BlobsThatPairAnotherWayAreNotOfOne) {
  Rig& rig = two_cameras();
  const Vector3d a = place_of(rig, 0), b = place_of(rig, 1), marker = apart_[1];
  const Vector3d across = (a - marker).cross(b - marker).normalized();
  // In one plane with both cameras: each blob lies on the lines of both blobs of the other camera.
  const Vector3d same_plane = marker + 0.2 * (b - a).normalized();
  for (const double off_m : {0.0, 0.0003}) {
    SCOPED_TRACE(off_m);
    ASSERT_EQ(match(rig, {marker, same_plane + off_m * across, apart_[2]}).size(), 3u);
    for (const Point& point : points_)
      EXPECT_EQ(point.certain, (point.position_in_world - apart_[2]).norm() < 0.01);
  }
  // Ten pixels off that plane nothing else fits.
  ASSERT_EQ(match(rig, {marker, same_plane + 0.05 * across, apart_[2]}).size(), 3u);
  for (const Point& point : points_) EXPECT_TRUE(point.certain);
}

TEST_F(Certain, AThirdViewTellsWhichPairIsRight) {
  const Vector3d a = place_of(four_cameras(), 0), b = place_of(four_cameras(), 1), marker = apart_[1];
  ASSERT_EQ(match(four_cameras(), {marker, marker + 0.2 * (b - a).normalized()}, 0b0111).size(), 2u);
  for (const Point& point : points_) {
    EXPECT_EQ(point.views, 3u);
    EXPECT_TRUE(point.certain);
  }
}

TEST_F(Certain, SpecksOfTwoPixelsAreNotForTwoCameras) {
  ASSERT_EQ(match(two_cameras(), apart_, 0xff, 2).size(), apart_.size());
  for (const Point& point : points_) EXPECT_FALSE(point.certain);
  // Four cameras that agree on a speck are another matter.
  ASSERT_EQ(match(four_cameras(), apart_, 0xff, 2).size(), apart_.size());
  for (const Point& point : points_) EXPECT_TRUE(point.certain);
}

TEST_F(Certain, ACameraThatShowsNothingWhereItShouldLeavesADoubt) {
  for (const CameraCalibration& camera : four_cameras().calibration.cameras)
    for (const Vector3d& marker : apart_) {
      const auto pixel = Camera(camera).project_pinhole(marker);
      ASSERT_TRUE(pixel && Camera(camera).inside(*pixel));
    }
  ASSERT_EQ(match(four_cameras(), apart_, 0b0011).size(), apart_.size());
  for (const Point& point : points_) EXPECT_FALSE(point.certain);
  // One that should is enough for a doubt.
  Rig three = four_of_which_look(3);
  ASSERT_EQ(match(three, apart_, 0b0011).size(), apart_.size());
  for (const Point& point : points_) EXPECT_FALSE(point.certain);
  // Neither can: nothing is missing.
  Rig two = four_of_which_look(2);
  ASSERT_EQ(match(two, apart_, 0b0011).size(), apart_.size());
  for (const Point& point : points_) EXPECT_TRUE(point.certain);
}

TEST_F(Certain, ThreeViewsAreEnoughThoughTheFourthShowsNothing) {
  ASSERT_EQ(match(four_cameras(), apart_, 0b1011).size(), apart_.size());
  for (const Point& point : points_) {
    EXPECT_EQ(point.views, 3u);
    EXPECT_TRUE(point.certain);
  }
}

TEST_F(Certain, APointThatATrackExpectedIsNotNew) {
  const Prediction prediction{TrackId{4}, apart_[0], 1e-6 * Eigen::Matrix3d::Identity()};
  ASSERT_EQ(match(four_cameras(), apart_, 0xff, kArea_px, {&prediction, 1}).size(), apart_.size());
  for (const Point& point : points_) EXPECT_EQ(point.certain, point.predicted_by == TrackId{});
}

}  // namespace
}  // namespace glint
