// SPDX-License-Identifier: MIT
// The walk along the epipolar line finds what testing every pair finds.
#include "host/match/pair_search.hpp"

#include <gtest/gtest.h>

#include <set>

#include "tests/unit/match/scene.hpp"

namespace glint {
namespace {

using namespace testing;

std::size_t compare(const Calibration& rig, const MatchOptions& options, std::size_t blobs_per_camera,
                    std::uint64_t seed) {
  const std::vector<Camera> cameras(rig.cameras.begin(), rig.cameras.end());
  BlobTable table(cameras, options);
  PairSearch search(cameras, options, table);
  std::mt19937_64 random(seed);
  std::vector<std::vector<shaders::BlobRecord>> blobs(rig.cameras.size());
  for (std::size_t c = 0; c < blobs.size(); ++c)
    for (std::size_t k = 0; k < blobs_per_camera; ++k)
      blobs[c].push_back(blob_at(rig.cameras[c], {uniform(random, 0, 1279), uniform(random, 0, 799)}));
  table.fill(std::vector<std::span<const shaders::BlobRecord>>(blobs.begin(), blobs.end()));
  std::size_t pairs = 0;
  for (std::size_t a = 0; a < cameras.size(); ++a)
    for (std::size_t b = 0; b < cameras.size(); ++b) {
      if (a == b) continue;
      for (std::uint32_t p = table.begin_of(a); p < table.end_of(a); ++p) {
        std::set<std::uint32_t> expected, found;
        for (std::uint32_t q = table.begin_of(b); q < table.end_of(b); ++q)
          if (search.meet(p, q)) expected.insert(q);
        search.partners(p, b, [&](const BlobPair& pair) { EXPECT_TRUE(found.insert(pair.b).second); });
        EXPECT_EQ(found, expected) << "cameras " << a << ", " << b;
        pairs += expected.size();
      }
    }
  return pairs;
}

TEST(PairSearch, FindsWhatTestingEveryPairFinds) {
  MatchOptions options;
  options.sigma_px = 0.5;
  options.gate_px = 2.0;
  EXPECT_GT(compare(ring_rig(5), options, 120, 31), 500u);
  options.max_range_m = 6.0;
  options.min_range_m = 2.0;
  EXPECT_GT(compare(ring_rig(4), options, 150, 32), 300u);
}

TEST(PairSearch, HoldsForCloseParallelCameras) {
  // A stereo pair that looks the same way: epipolar lines run along the rows, one epipole at infinity.
  Calibration rig = ring_rig(2);
  rig.cameras[1].world_from_camera = rig.cameras[0].world_from_camera;
  rig.cameras[1].world_from_camera.translation +=
      rig.cameras[0].world_from_camera.rotation * Eigen::Vector3d(0.5, 0, 0);
  MatchOptions options;
  options.sigma_px = 0.5;
  options.gate_px = 2.0;
  options.max_range_m = 8.0;
  EXPECT_GT(compare(rig, options, 200, 33), 50u);
}

TEST(PairSearch, HoldsWhereTheOtherCameraIsInTheImage) {
  // Each camera sees the other: the epipole lies within the image.
  Calibration rig = ring_rig(2);
  rig.cameras[0].world_from_camera = looking_at({-2, 0.4, 1}, {0, 0, 1});
  rig.cameras[1].world_from_camera = looking_at({2, 0.5, 1.2}, {0, 0, 1});
  MatchOptions options;
  options.sigma_px = 0.5;
  options.gate_px = 2.0;
  EXPECT_GT(compare(rig, options, 200, 34), 50u);
}

TEST(PairSearch, RaysInOneLineDoNotMeet) {
  Calibration rig = ring_rig(2);
  rig.cameras[0].world_from_camera = looking_at({-2, 0, 1}, {0, 0, 1});
  rig.cameras[1].world_from_camera = looking_at({2, 0, 1}, {0, 0, 1});
  const std::vector<Camera> cameras(rig.cameras.begin(), rig.cameras.end());
  const MatchOptions options;
  BlobTable table(cameras, options);
  PairSearch search(cameras, options, table);
  std::vector<std::vector<shaders::BlobRecord>> blobs;
  for (const CameraCalibration& c : rig.cameras) blobs.push_back({blob_at(c, {c.cx_px, c.cy_px})});
  table.fill(std::vector<std::span<const shaders::BlobRecord>>(blobs.begin(), blobs.end()));
  EXPECT_FALSE(search.meet(0, 1));
}

}  // namespace
}  // namespace glint
