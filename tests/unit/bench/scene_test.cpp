// SPDX-License-Identifier: MIT
// The pictures are the same for everybody, or no two results could be compared.
#include "host/bench/scene.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "host/base/error.hpp"
#include "host/bench/check.hpp"

namespace glint::bench {
namespace {

SceneOptions small() {
  SceneOptions options;
  options.cameras = 2;
  options.ticks = 2;
  options.width_px = 320;
  options.height_px = 240;
  options.blobs_per_camera = 7;
  return options;
}

std::uint64_t hash(Scene& scene) {  // FNV-1a
  std::uint64_t h = 0xcbf29ce484222325u;
  for (const std::byte b : scene.memory()) h = (h ^ std::to_integer<std::uint64_t>(b)) * 0x100000001b3u;
  return h;
}

TEST(Scene, IsTheSameOnEveryMachine) {
  Scene scene(small());
  EXPECT_EQ(hash(scene), 0xf4fa8bb03354a206u) << std::hex << hash(scene);
  SceneOptions odd = small();  // rows with padding
  odd.width_px = 331;
  odd.height_px = 243;
  Scene padded(odd);
  EXPECT_EQ(hash(padded), 0xc4aeb3bcc1b3e83fu) << std::hex << hash(padded);
}

TEST(Scene, DiffersBySeed) {
  SceneOptions other = small();
  other.seed = 2;
  Scene a(small()), b(other);
  EXPECT_NE(hash(a), hash(b));
}

TEST(Scene, ShowsAsManyBlobsAsAsked) {
  for (const unsigned blobs : {0u, 1u, 20u}) {
    SceneOptions options = small();
    options.blobs_per_camera = blobs;
    const Scene scene(options);
    const Expected expected(scene);
    EXPECT_EQ(expected.found(0, 2), 2u * blobs);
    EXPECT_EQ(expected.found(1, 1), blobs);
  }
}

TEST(Scene, HasTheNoiseThatIsAskedFor) {
  SceneOptions options = small();
  options.blobs_per_camera = 0;
  for (const double noise : {0.0, 1.2, 2.5}) {
    options.noise_grey = noise;
    const Scene scene(options);
    double sum = 0.0, squares = 0.0;
    const double n = 320.0 * 240.0;
    for (std::size_t i = 0; i < 320 * 240; ++i) {
      const double d = double{scene.pixels(0, 0)[i] + 0.0} - double{scene.background(0)[i] + 0.0};
      sum += d;
      squares += d * d;
    }
    // rounding to whole grey levels adds 1/12
    EXPECT_NEAR(std::sqrt(squares / n), noise > 0.0 ? std::sqrt(noise * noise + 1.0 / 12.0) : 0.0, 0.05);
    EXPECT_NEAR(sum / n, 0.0, 0.05);
  }
}

TEST(Scene, CopiesCamerasIntoMemoryOfTheirOwn) {
  SceneOptions options = small();
  options.cameras = 5;
  options.drawn_cameras = 2;
  const Scene scene(options);
  const std::size_t bytes = 320 * 240;
  EXPECT_NE(scene.pixels(1, 4), scene.pixels(1, 0));
  EXPECT_TRUE(std::equal(scene.pixels(1, 4), scene.pixels(1, 4) + bytes, scene.pixels(1, 0)));
  EXPECT_FALSE(std::equal(scene.pixels(1, 4), scene.pixels(1, 4) + bytes, scene.pixels(1, 1)));
  EXPECT_EQ(scene.limit(4).data(), scene.limit(0).data());
  EXPECT_EQ(Expected(scene).found(0, 5), 5u * 7u);
}

TEST(Scene, LiesAsDevicesReadIt) {
  SceneOptions options = small();
  options.width_px = 331;
  options.height_px = 243;
  Scene scene(options);
  EXPECT_EQ(scene.stride_bytes(), 336u);
  for (unsigned tick = 0; tick < 2; ++tick) {
    for (const gpu::ImageView& image : scene.images(tick)) {
      EXPECT_EQ(reinterpret_cast<std::uintptr_t>(image.pixels) % 4096, 0u);
      const auto* end = reinterpret_cast<const std::byte*>(image.pixels) + 336 * 248;
      EXPECT_LE(end, scene.memory().data() + scene.memory().size());
    }
  }
}

TEST(Scene, RefusesWhatDoesNotFit) {
  SceneOptions options = small();
  options.blobs_per_camera = 1000;
  EXPECT_THROW(Scene{options}, Error);
  options = small();
  options.width_px = 63;
  EXPECT_THROW(Scene{options}, Error);
}

}  // namespace
}  // namespace glint::bench
