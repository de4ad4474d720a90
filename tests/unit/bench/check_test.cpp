// SPDX-License-Identifier: MIT
// A detector that is wrong in any one thing is found out.
#include "host/bench/check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "tests/unit/bench/altered_detector.hpp"

namespace glint::bench {
namespace {

using test::AlteredDetector;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Scene small_scene() {
  SceneOptions options;
  options.cameras = 3;
  options.drawn_cameras = 2;
  options.ticks = 2;
  options.width_px = 320;
  options.height_px = 240;
  options.blobs_per_camera = 5;
  return Scene(options);
}

/// What the check says of a detector that makes `change` to blob 3 of camera 2 in tick 1.
std::string verdict_on(const std::function<void(gpu::BlobRecord&)>& change) {
  const Scene scene = small_scene();
  const Expected expected(scene);
  AlteredDetector detector(scene.formats(),
                           [&](unsigned tick, std::vector<std::vector<gpu::BlobRecord>>& cameras) {
                             if (tick == 1) change(cameras[1][2]);
                           });
  set_limits(scene, detector);
  return expected.difference(detector);
}

TEST(Check, PassesTheReference) {
  EXPECT_THAT(verdict_on([](gpu::BlobRecord&) {}), IsEmpty());
}

TEST(Check, PassesTheCpuDetectorWithAllCamerasAndWithFewer) {
  const Scene scene = small_scene();
  const Expected expected(scene);
  for (const unsigned cameras : {1u, 3u}) {
    std::vector<gpu::CameraFormat> formats = scene.formats();
    formats.resize(cameras);
    const auto detector = gpu::make_cpu_detector(formats, {});
    set_limits(scene, *detector, cameras);
    EXPECT_THAT(expected.difference(*detector, cameras), IsEmpty());
  }
}

TEST(Check, SeesEveryWholeNumber) {
  using Record = gpu::BlobRecord;
  for (auto field : {&Record::area_px, &Record::sum, &Record::weight, &Record::peak, &Record::x_min_px,
                     &Record::y_min_px, &Record::x_max_px, &Record::y_max_px, &Record::flags}) {
    EXPECT_THAT(verdict_on([&](Record& r) { ++(r.*field); }), HasSubstr("tick 1, camera 2, blob 3: "));
  }
  EXPECT_THAT(verdict_on([](Record& r) { r.sum += 1; }), HasSubstr("sum is "));
  EXPECT_THAT(verdict_on([](Record& r) { r.camera = 0; }), HasSubstr("a blob of camera 1"));
}

TEST(Check, SeesCentroidsThatAreAThousandthOff) {
  EXPECT_THAT(verdict_on([](gpu::BlobRecord& r) { r.x_px += 0.0005f; }), IsEmpty());
  EXPECT_THAT(verdict_on([](gpu::BlobRecord& r) { r.x_px += 0.0015f; }), HasSubstr("x_px is "));
  EXPECT_THAT(verdict_on([](gpu::BlobRecord& r) { r.y_px -= 0.0015f; }), HasSubstr("y_px is "));
  const float focal_px = 914.0f * 320.0f / 1280.0f;
  EXPECT_THAT(verdict_on([&](gpu::BlobRecord& r) { r.x_undist += 0.0005f / focal_px; }), IsEmpty());
  EXPECT_THAT(verdict_on([&](gpu::BlobRecord& r) { r.x_undist += 0.0015f / focal_px; }),
              HasSubstr("x_undist is "));
  EXPECT_THAT(verdict_on([&](gpu::BlobRecord& r) { r.y_undist -= 0.0015f / focal_px; }),
              HasSubstr("y_undist is "));
  EXPECT_THAT(verdict_on([](gpu::BlobRecord& r) { r.x_px = std::numeric_limits<float>::quiet_NaN(); }),
              HasSubstr("x_px is "));
  EXPECT_THAT(verdict_on([](gpu::BlobRecord& r) { r.var_xy_px2 += 1.0f; }), HasSubstr("var_xy_px2 is "));
}

TEST(Check, SeesALostBlobAndABreakdown) {
  const Scene scene = small_scene();
  const Expected expected(scene);
  AlteredDetector loses(scene.formats(), [](unsigned, std::vector<std::vector<gpu::BlobRecord>>& cameras) {
    cameras[2].pop_back();
  });
  set_limits(scene, loses);
  EXPECT_EQ(expected.difference(loses), "tick 0, camera 3: 4 blobs instead of 5");
  AlteredDetector breaks(scene.formats(), {});
  set_limits(scene, breaks);
  breaks.break_after(1);
  EXPECT_EQ(expected.difference(breaks), "tick 1: it failed: gone");
}

}  // namespace
}  // namespace glint::bench
