// SPDX-License-Identifier: MIT
// Missing markers, cameras that are off and blinking pixels: in images and truth alike.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <optional>
#include <set>
#include <vector>

#include "host/sim/faults.hpp"
#include "host/sim/renderer.hpp"
#include "host/sim/scene.hpp"
#include "host/sim/sim_source.hpp"

namespace glint {
namespace {

float light_at(const std::vector<float>& light, const SimOptions& options, const sim::MarkerView& view) {
  return light[static_cast<std::size_t>(std::lround(view.y_px)) * options.width_px +
               static_cast<std::size_t>(std::lround(view.x_px))];
}

TEST(Missing, MarkersGiveNoLightAndNobodyExpectsThem) {
  SimOptions options;
  const Scene whole(options);
  options.faults.missing_rate = 0.3;
  const Scene scene(options);
  sim::Renderer renderer(scene);
  TickTruth with, without;
  int lost = 0, kept = 0;
  for (std::uint64_t tick = 0; tick < 60; tick += 3) {
    scene.truth(tick, with);
    whole.truth(tick, without);
    for (std::uint32_t c = 0; c < 4; ++c) {
      const std::vector<float> light = renderer.light(c, tick);
      for (std::uint32_t m = 0; m < scene.markers(); ++m) {
        const sim::MarkerView& view = without.views_of(c)[m];
        const bool visible = (with.markers[m].visible >> c & 1u) != 0,
                   clean = (with.markers[m].clean >> c & 1u) != 0,
                   clean_before = (without.markers[m].clean >> c & 1u) != 0;
        if (sim::missing(options, c, tick, m)) {
          EXPECT_FALSE(visible || clean || with.views_of(c)[m].imaged);
          if (clean_before) {
            EXPECT_LT(light_at(light, options, view), 1.0f);
            ++lost;
          }
        } else if (clean_before) {
          EXPECT_TRUE(visible && clean);
          EXPECT_GT(light_at(light, options, view), 20.0f);
          ++kept;
        }
      }
    }
  }
  EXPECT_NEAR(static_cast<double>(lost) / (lost + kept), 0.3, 0.04);
}

TEST(Missing, IsDrawnForEachMarkerCameraAndTickAlone) {
  SimOptions options;
  options.faults.missing_rate = 0.1;
  const auto share = [&](auto&& one) {
    int both = 0, first = 0;
    for (std::uint64_t i = 0; i < 40000; ++i) {
      const auto [a, b] = one(i);
      first += a ? 1 : 0, both += a && b ? 1 : 0;
    }
    EXPECT_NEAR(first, 4000, 250);
    return static_cast<double>(both) / first;
  };
  using Both = std::pair<bool, bool>;
  const auto is = [&](std::uint32_t c, std::uint64_t t, std::uint32_t m) {
    return sim::missing(options, c, t, m);
  };
  EXPECT_NEAR(share([&](std::uint64_t i) { return Both(is(1, i, 2), is(1, i, 3)); }), 0.1, 0.025);
  EXPECT_NEAR(share([&](std::uint64_t i) { return Both(is(1, i, 2), is(2, i, 2)); }), 0.1, 0.025);
  EXPECT_NEAR(share([&](std::uint64_t i) { return Both(is(1, i, 2), is(1, i + 1, 2)); }), 0.1, 0.025);
}

TEST(Off, FramesNeverComeForAsLongAsAsked) {
  SimOptions options;
  options.width_px = 320;
  options.height_px = 200;
  options.markers = 5;
  options.faults.off = {{1, 10, 5}, {1, 30, 2}, {3, 12, 100}};
  const Scene scene(options);
  SimSource source(scene, {false, 40});
  FramePool pool(std::vector<FrameSize>(4, {320, 200}), 2);
  FrameSet set;
  TickTruth truth;
  std::uint64_t missing = 0;
  for (std::uint64_t tick = 0; tick < 40; ++tick) {
    ASSERT_EQ(source.read(pool, set), ReadStatus::Ok);
    scene.truth(tick, truth);
    const bool one = (tick >= 10 && tick < 15) || (tick >= 30 && tick < 32), three = tick >= 12;
    for (std::uint32_t c = 0; c < 4; ++c) {
      const bool off = (c == 1 && one) || (c == 3 && three);
      EXPECT_EQ(set.frames[c].has_value(), !off) << tick;
      EXPECT_EQ((truth.delivered >> c & 1u) == 0, off);
      for (const MarkerTruth& marker : truth.markers) {
        if (off) {
          EXPECT_EQ(marker.clean >> c & 1u, 0u);
        }
      }
      missing += off ? 1 : 0;
    }
  }
  EXPECT_EQ(source.counters().missing, missing);
}

TEST(Blinks, LightUpAtOtherPlacesEachTimeAndAreUndone) {
  SimOptions options;
  options.markers = 6;
  const Scene plain(options);
  options.faults.blinks_per_frame = 3.0;
  const Scene scene(options);
  sim::Renderer renderer(scene), reference(plain);
  const std::size_t pixels = std::size_t{options.width_px} * options.height_px;
  std::vector<std::uint8_t> image(pixels), expected(pixels);
  sim::BufferMemory memory, other;
  std::set<std::pair<int, int>> places;
  std::uint32_t total = 0, doubles = 0;
  constexpr std::uint64_t kTicks = 150;
  for (std::uint64_t tick = 0; tick < kTicks; ++tick) {
    renderer.render(2, tick, image.data(), options.width_px, memory);
    reference.render(2, tick, expected.data(), options.width_px, other);
    // Put into a copy of the picture without: then all is the same, also what earlier ticks left behind.
    std::vector<std::uint8_t> with = expected;
    sim::Blinks blinks(options, 2, tick);
    total += blinks.count();
    for (std::uint32_t i = 0; i < blinks.count(); ++i) {
      const sim::Blink blink = blinks.next();
      EXPECT_GE(blink.grey, 60);
      places.insert({blink.x_px, blink.y_px});
      doubles += blink.size_px == 2 ? 1u : 0u;
      for (int y = blink.y_px; y < blink.y_px + blink.size_px; ++y) {
        for (int x = blink.x_px; x < blink.x_px + blink.size_px; ++x) {
          std::uint8_t& pixel =
              with[static_cast<std::size_t>(y) * options.width_px + static_cast<std::size_t>(x)];
          pixel = std::max(pixel, blink.grey);
        }
      }
    }
    ASSERT_EQ(image, with) << tick;
  }
  EXPECT_NEAR(total, 3.0 * kTicks, 70.0);  // three standard deviations of a Poisson count are 64
  EXPECT_NEAR(doubles, 0.5 * total, 0.1 * total);
  EXPECT_GT(places.size(), total * 0.98);
}

TEST(Blinks, NearAMarkerItIsNotClean) {
  SimOptions options;
  const Scene plain(options);
  options.faults.blinks_per_frame = 60.0;
  const Scene scene(options);
  TickTruth with, without;
  int spoilt = 0;
  for (std::uint64_t tick = 0; tick < 30; ++tick) {
    scene.truth(tick, with);
    plain.truth(tick, without);
    for (std::uint32_t c = 0; c < 4; ++c) {
      for (std::uint32_t m = 0; m < scene.markers(); ++m) {
        const sim::MarkerView& view = with.views_of(c)[m];
        EXPECT_EQ(with.markers[m].visible, without.markers[m].visible);
        if ((without.markers[m].clean >> c & 1u) == 0) continue;
        sim::Blinks blinks(options, c, tick);
        double nearest = 1e9;
        for (std::uint32_t i = 0; i < blinks.count(); ++i) {
          const sim::Blink blink = blinks.next();
          const double half = 0.5 * (blink.size_px - 1);
          nearest =
              std::min(nearest, std::hypot(blink.x_px + half - view.x_px, blink.y_px + half - view.y_px) -
                                    view.radius_px);
        }
        const bool clean = (with.markers[m].clean >> c & 1u) != 0;
        if (nearest < 4.5) {
          EXPECT_FALSE(clean);
          ++spoilt;
        } else if (nearest > 5.5) {
          EXPECT_TRUE(clean);
        }
      }
    }
  }
  EXPECT_GT(spoilt, 5);
}

}  // namespace
}  // namespace glint
