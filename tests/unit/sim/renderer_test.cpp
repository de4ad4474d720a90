// SPDX-License-Identifier: MIT
// Rendered images obey the physics that they claim.
#include "host/sim/renderer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <vector>

namespace glint::sim {
namespace {

constexpr std::uint32_t kWidth = 1280, kHeight = 800;

struct Image {
  std::vector<std::uint8_t> pixels = std::vector<std::uint8_t>(kWidth * kHeight);
  BufferMemory memory;
  void draw(Renderer& renderer, std::uint32_t camera, std::uint64_t tick) {
    renderer.render(camera, tick, pixels.data(), kWidth, memory);
  }
};

std::uint64_t hash(const std::vector<std::uint8_t>& pixels) {
  std::uint64_t hash = 14695981039346656037u;  // FNV-1a
  for (const std::uint8_t pixel : pixels) hash = (hash ^ pixel) * 1099511628211u;
  return hash;
}

SimOptions still(std::uint32_t markers) {
  SimOptions options;
  options.markers = markers;
  options.max_speed_m_s = 0.0;
  options.bright_spots = 0;
  return options;
}

/// Light of one marker that stands alone: sum, mean and variance along both axes.
struct Moments {
  double sum = 0.0, x = 0.0, y = 0.0, xx = 0.0, yy = 0.0, peak = 0.0;
};
Moments moments_around(const std::vector<float>& light, double x0, double y0, int reach) {
  Moments m;
  for (int y = static_cast<int>(y0) - reach; y <= static_cast<int>(y0) + reach; ++y) {
    for (int x = static_cast<int>(x0) - reach; x <= static_cast<int>(x0) + reach; ++x) {
      const double value =
          static_cast<double>(light[static_cast<std::size_t>(y) * kWidth + static_cast<std::size_t>(x)]);
      m.sum += value;
      m.x += value * x;
      m.y += value * y;
      m.xx += value * x * x;
      m.yy += value * y * y;
      m.peak = std::max(m.peak, value);
    }
  }
  m.x /= m.sum;
  m.y /= m.sum;
  m.xx = m.xx / m.sum - m.x * m.x;
  m.yy = m.yy / m.sum - m.y * m.y;
  return m;
}

TEST(Renderer, SameSeedSameImagesWhateverTheBufferHeldBefore) {
  const Scene scene({});
  Renderer one(scene), other(scene);
  Image used, fresh;
  for (std::uint64_t tick : {0u, 1u, 5u, 17u, 40u}) used.draw(one, 1, tick);
  used.draw(one, 2, 7);  // even of another camera: only if the memory is thrown away
  used.memory = {};
  used.draw(one, 1, 90);
  used.draw(one, 1, 91);
  fresh.draw(other, 1, 91);
  EXPECT_EQ(used.pixels, fresh.pixels);
  fresh.draw(other, 1, 90);
  EXPECT_NE(used.pixels, fresh.pixels);
}

TEST(Renderer, ImagesOfASeedNeverChange) {
  // If this fails after a change of the image model, recordings made from seeds change too: say so in the
  // changelog and put the new number here.
  const Scene scene({});
  Renderer renderer(scene);
  Image image;
  image.draw(renderer, 0, 12);
  EXPECT_EQ(hash(image.pixels), 9636312590225542209u);
}

TEST(Renderer, BrightnessFollowsTheLaw) {
  // Grey of the disc times its area, with nothing lost in the blur.
  const Scene scene(still(60));
  Renderer renderer(scene);
  TickTruth truth;
  scene.truth(0, truth);
  int compared = 0;
  for (std::uint32_t c = 0; c < 4; ++c) {
    const std::vector<float> light = renderer.light(c, 0);
    for (std::uint32_t m = 0; m < scene.markers(); ++m) {
      if ((truth.markers[m].clean & (1u << c)) == 0) continue;
      const MarkerView& view = truth.views_of(c)[m];
      const auto reach = static_cast<int>(view.radius_px + 5.0);
      const bool crowded =
          std::any_of(truth.views_of(c).begin(), truth.views_of(c).end(), [&](const MarkerView& other) {
            return &other != &view && other.imaged && std::abs(other.x_px - view.x_px) < 2 * reach + 8 &&
                   std::abs(other.y_px - view.y_px) < 2 * reach + 8;
          });
      if (crowded || view.x_px < reach || view.y_px < reach || view.x_px > 1278.0 - reach ||
          view.y_px > 798.0 - reach)
        continue;
      std::array<OutlinePoint, 64> outline;
      const SimCamera& camera = scene.camera(c, 0);
      camera.outline(camera.in_camera(truth.markers[m].position_in_world), 0.0063, outline);
      const OutlineMoments shape = moments(outline);
      const Moments found = moments_around(light, view.x_px, view.y_px, reach);
      const double expected = marker_grey(view.distance_m, 137e-6) * shape.area_px2;
      EXPECT_NEAR(found.sum, expected, 3e-3 * expected);
      EXPECT_NEAR(found.x, shape.mean_px.x(), 0.003);
      EXPECT_NEAR(found.y, shape.mean_px.y(), 0.003);
      ++compared;
    }
  }
  EXPECT_GT(compared, 50);
}

TEST(Renderer, PeaksSpanTheSensorFromNearToFar) {
  EXPECT_NEAR(marker_grey(1.5, 137e-6), 222.0, 5.0);
  EXPECT_NEAR(marker_grey(5.0, 137e-6), 76.0, 5.0);
  // Far away the ring light's observation angle no longer matters: inverse square.
  EXPECT_NEAR(marker_grey(50.0, 137e-6) / marker_grey(100.0, 137e-6), 4.0, 0.2);
  EXPECT_DOUBLE_EQ(marker_grey(3.0, 274e-6), 2.0 * marker_grey(3.0, 137e-6));
}

TEST(Renderer, NoiseHasTheVarianceOfTheModel) {
  // The same still scene over many ticks; marker pixels get fresh noise each time.
  SimOptions options = still(8);
  options.faults.extra_noise_grey = 1.0;  // well above rounding, so that rounding adds its 1/12
  const Scene scene(options);
  Renderer renderer(scene);
  const NoiseModel& noise = renderer.noise();
  const std::vector<float> light = renderer.light(0, 0);
  constexpr int kTicks = 400;
  std::vector<std::size_t> bright;
  for (std::size_t i = 0; i < light.size(); ++i) {
    if (light[i] > 20.0f) bright.push_back(i);
  }
  ASSERT_GT(bright.size(), 40u);
  std::vector<double> sum(bright.size()), squares(bright.size());
  Image image;
  for (int tick = 0; tick < kTicks; ++tick) {
    image.draw(renderer, 0, static_cast<std::uint64_t>(tick));
    for (std::size_t i = 0; i < bright.size(); ++i) {
      sum[i] += image.pixels[bright[i]];
      squares[i] += double{1.0} * image.pixels[bright[i]] * image.pixels[bright[i]];
    }
  }
  double found = 0.0, expected = 0.0;
  for (std::size_t i = 0; i < bright.size(); ++i) {
    const double mean = sum[i] / kTicks;
    found += (squares[i] / kTicks - mean * mean) * kTicks / (kTicks - 1);
    expected += static_cast<double>(noise.variance_grey2(static_cast<float>(mean))) + 1.0 / 12.0;
  }
  EXPECT_NEAR(found / expected, 1.0, 0.03);
}

TEST(Renderer, DarkFrameIsBlackLevelPlusStrayLight) {
  const Scene scene(still(0));
  Renderer renderer(scene);
  Image image;
  image.draw(renderer, 3, 0);
  double sum = 0.0;
  for (const std::uint8_t pixel : image.pixels) sum += pixel;
  const double mean = sum / static_cast<double>(image.pixels.size());
  EXPECT_GT(mean, 8.0);
  EXPECT_LT(mean, 14.0);
  EXPECT_LT(*std::max_element(image.pixels.begin(), image.pixels.end()), 22);
}

TEST(Renderer, BrightSpotsStandStill) {
  SimOptions options = still(0);
  options.bright_spots = 5;
  const Scene scene(options);
  Renderer renderer(scene);
  Image image;
  for (std::uint64_t tick : {0u, 33u}) {
    image.draw(renderer, 1, tick);
    for (const BrightSpot& spot : scene.spots(1)) {
      const auto x = static_cast<std::size_t>(std::lround(spot.x_px)),
                 y = static_cast<std::size_t>(std::lround(spot.y_px));
      EXPECT_GT(image.pixels[y * kWidth + x], 8.0 + 0.5 * spot.grey);
    }
  }
}

TEST(Renderer, MotionBlurLengthensTheBlobByItsPath) {
  // Uniform motion over a path of L pixels adds L^2 / 12 to the variance along it. A long exposure shows it.
  SimOptions options = still(10);
  options.max_speed_m_s = 8.0;
  options.exposure_s = 1e-3;
  const Scene moving(options);
  options.exposure_s = 1e-6;
  const Scene frozen(options);
  Renderer blurred(moving), sharp(frozen);
  TickTruth truth;
  int compared = 0;
  for (std::uint64_t tick = 0; tick < 30; tick += 3) {
    moving.truth(tick, truth);
    const std::vector<float> with = blurred.light(0, tick), without = sharp.light(0, tick);
    for (std::uint32_t m = 0; m < 10; ++m) {
      const MarkerView& view = truth.views_of(0)[m];
      const auto reach = static_cast<int>(view.radius_px + 5.0);
      if ((truth.markers[m].clean & 1u) == 0 || view.x_px < 30 || view.y_px < 30 || view.x_px > 1250 ||
          view.y_px > 770)
        continue;
      const bool crowded =
          std::any_of(truth.views_of(0).begin(), truth.views_of(0).end(), [&](const MarkerView& other) {
            return &other != &view && other.imaged &&
                   std::hypot(other.x_px - view.x_px, other.y_px - view.y_px) < 45;
          });
      const SimCamera& camera = moving.camera(0, tick);
      const double t = moving.mid_exposure_s(tick);
      const auto at = [&](double time) {
        return camera.project(camera.in_camera(moving.marker(m, time).position_in_world));
      };
      const Eigen::Vector2d path = at(t + 5e-4) - at(t - 5e-4);
      // A bounce within the exposure folds the path.
      const bool straight = (at(t + 5e-4) + at(t - 5e-4) - 2.0 * at(t)).norm() < 0.02;
      if (crowded || !straight) continue;
      const Moments a = moments_around(with, view.x_px, view.y_px, reach);
      const Moments b = moments_around(without, view.x_px, view.y_px, reach);
      EXPECT_NEAR(a.xx - b.xx, path.x() * path.x() / 12.0, 0.02 + 0.02 * path.x() * path.x() / 12.0);
      EXPECT_NEAR(a.yy - b.yy, path.y() * path.y() / 12.0, 0.02 + 0.02 * path.y() * path.y() / 12.0);
      ++compared;
    }
  }
  EXPECT_GT(compared, 20);
}

TEST(Renderer, HiddenMarkersAreDark) {
  SimOptions options = still(60);
  options.occluders = 15;
  const Scene scene(options);
  Renderer renderer(scene);
  TickTruth truth;
  scene.truth(0, truth);
  const std::vector<float> light = renderer.light(0, 0);
  int hidden = 0;
  for (std::uint32_t m = 0; m < scene.markers(); ++m) {
    const MarkerView& view = truth.views_of(0)[m];
    if (!view.imaged || view.x_px < 5 || view.x_px > 1270 || view.y_px < 5 || view.y_px > 790) continue;
    unsigned lost = 0;
    if (scene.may_be_hidden(0, 0, m, truth.views_of(0))) {
      scene.sample_disc(0, 0, m, 0.0, truth.views_of(0), 100,
                        [&](const Eigen::Vector3d&, bool is) { lost += is ? 1u : 0u; });
    }
    const float at = light[static_cast<std::size_t>(std::lround(view.y_px)) * kWidth +
                           static_cast<std::size_t>(std::lround(view.x_px))];
    if (lost == 100) {
      ++hidden;
      EXPECT_LT(at, 5.0f);
    } else if (lost == 0) {
      EXPECT_GT(at, 30.0f);
    }
  }
  EXPECT_GT(hidden, 0);
}

TEST(Renderer, SaturatesInsteadOfWrapping) {
  SimOptions options = still(20);
  options.exposure_s = 5e-3;
  const Scene scene(options);
  Renderer renderer(scene);
  Image image;
  image.draw(renderer, 0, 0);
  const std::vector<float> light = renderer.light(0, 0);
  int saturated = 0;
  for (std::size_t i = 0; i < light.size(); ++i) {
    if (light[i] < 400.0f) continue;
    ++saturated;
    EXPECT_EQ(image.pixels[i], 255);
  }
  EXPECT_GT(saturated, 100);
}

}  // namespace
}  // namespace glint::sim
