// SPDX-License-Identifier: MIT
// The pictures that every contender gets: a dim room, lamps, sensor noise, and round markers.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>
#include <span>
#include <vector>

#include "gpu/detector.hpp"

namespace glint::benchmarks {

struct SceneOptions {
  unsigned cameras = 4;
  std::uint32_t width_px = 1280, height_px = 800;
  unsigned blobs_per_camera = 20;
  unsigned ticks = 4;    ///< different frame sets, shown in rotation
  unsigned margin = 40;  ///< limit = background + margin
  std::uint64_t seed = 1;
};

/// The same pictures for the same options on every machine. Background 8 to 14 grey levels with a fixed
/// pattern, five reflections per camera that stand still, noise of 1.2 grey levels, anti-aliased discs of
/// 3 to 40 px diameter.
class Scene {
 public:
  explicit Scene(const SceneOptions& options)
      : options_(options),
        frame_bytes_((std::size_t{options.width_px} * options.height_px + kPage - 1) / kPage * kPage),
        memory_bytes_(frame_bytes_ * options.cameras * options.ticks),
        memory_(static_cast<std::byte*>(std::aligned_alloc(kPage, memory_bytes_)), &std::free),
        random_(options.seed * 0x9e3779b97f4a7c15u + 1) {
    if (!memory_) throw std::bad_alloc();
    make_noise_table();
    for (unsigned camera = 0; camera < options.cameras; ++camera) {
      const std::vector<float> room = make_room();
      backgrounds_.emplace_back(room.size());
      std::transform(room.begin(), room.end(), backgrounds_.back().begin(), [](float v) { return grey(v); });
      limits_.emplace_back(room.size());
      std::transform(room.begin(), room.end(), limits_.back().begin(),
                     [&](float v) { return grey(std::round(v) + static_cast<float>(options_.margin)); });
      for (unsigned tick = 0; tick < options.ticks; ++tick) draw(tick, camera, room);
    }
  }

  const SceneOptions& options() const noexcept { return options_; }
  /// All frames in one page-aligned piece, for Detector::adopt_frame_memory().
  std::span<std::byte> memory() noexcept { return {memory_.get(), memory_bytes_}; }
  std::span<const std::uint8_t> background(unsigned camera) const noexcept { return backgrounds_[camera]; }
  std::span<const std::uint8_t> limit(unsigned camera) const noexcept { return limits_[camera]; }

  std::uint8_t* pixels(unsigned tick, unsigned camera) const noexcept {
    const std::size_t frame = std::size_t{tick} * options_.cameras + camera;
    return reinterpret_cast<std::uint8_t*>(memory_.get()) + frame * frame_bytes_;
  }
  std::vector<gpu::ImageView> images(unsigned tick) const {
    std::vector<gpu::ImageView> result;
    for (unsigned camera = 0; camera < options_.cameras; ++camera) {
      result.push_back({pixels(tick, camera), options_.width_px, options_.height_px, options_.width_px,
                        gpu::PixelFormat::Grey8});
    }
    return result;
  }

  /// A wide lens, whose model can be inverted everywhere in the image.
  std::vector<gpu::CameraFormat> formats() const {
    gpu::CameraFormat format{options_.width_px, options_.height_px, {}};
    const double scale = options_.width_px / 1280.0;
    format.lens = {914.0 * scale,
                   914.0 * scale,
                   0.5 * options_.width_px,
                   0.5 * options_.height_px,
                   {-0.32, 0.12, 0.0006, -0.0004, -0.015}};
    return std::vector<gpu::CameraFormat>(options_.cameras, format);
  }

 private:
  static constexpr std::size_t kPage = 4096;

  static std::uint8_t grey(float v) noexcept {
    return static_cast<std::uint8_t>(std::clamp(std::lround(v), 0l, 255l));
  }
  std::uint64_t next() noexcept {  // xorshift64*, Vigna 2016
    random_ ^= random_ >> 12;
    random_ ^= random_ << 25;
    random_ ^= random_ >> 27;
    return random_ * 0x2545f4914f6cdd1du;
  }
  double uniform(double from, double to) noexcept {
    return from + (to - from) * static_cast<double>(next() >> 11) * 0x1p-53;
  }

  /// Drawing a normal number for every pixel is slow: draw from a table of them.
  void make_noise_table() {
    noise_.resize(1u << 14);
    for (float& n : noise_) {
      const double radius = std::sqrt(-2.0 * std::log(uniform(1e-12, 1.0)));
      n = static_cast<float>(1.2 * radius * std::cos(uniform(0.0, 6.283185307179586)));
    }
  }

  std::vector<float> make_room() {
    std::vector<float> room(std::size_t{options_.width_px} * options_.height_px);
    for (float& v : room) v = 8.0f + static_cast<float>(next() % 7);
    for (int i = 0; i < 5; ++i) {
      const double d = uniform(6.0, 14.0);
      add_disc(room, uniform(20.0, options_.width_px - 20.0), uniform(20.0, options_.height_px - 20.0), d,
               uniform(150.0, 190.0));
    }
    return room;
  }

  void add_disc(std::vector<float>& image, double x, double y, double diameter, double brightness) const {
    const double r = 0.5 * diameter;
    const auto from = [](double v) { return static_cast<long>(std::max(0.0, v)); };
    const long x_end = std::min<long>(options_.width_px, std::lround(x + r + 2.0));
    const long y_end = std::min<long>(options_.height_px, std::lround(y + r + 2.0));
    for (long py = from(y - r - 2.0); py < y_end; ++py) {
      for (long px = from(x - r - 2.0); px < x_end; ++px) {
        const double inside = std::clamp(
            r + 0.5 - std::hypot(static_cast<double>(px) - x, static_cast<double>(py) - y), 0.0, 1.0);
        image[static_cast<std::size_t>(py) * options_.width_px + static_cast<std::size_t>(px)] +=
            static_cast<float>(inside * brightness);
      }
    }
  }

  void draw(unsigned tick, unsigned camera, const std::vector<float>& room) {
    std::vector<float> image = room;
    struct Disc {
      double x, y, d;
    };
    std::vector<Disc> discs;
    for (unsigned tries = 0; discs.size() < options_.blobs_per_camera && tries < 100000; ++tries) {
      const double d = uniform(3.0, 40.0);
      const Disc disc{uniform(24.0, options_.width_px - 24.0), uniform(24.0, options_.height_px - 24.0), d};
      const bool free = std::none_of(discs.begin(), discs.end(), [&](const Disc& other) {
        return std::hypot(other.x - disc.x, other.y - disc.y) < 0.5 * (other.d + disc.d) + 4.0;
      });
      if (!free) continue;
      discs.push_back(disc);
      add_disc(image, disc.x, disc.y, disc.d, uniform(120.0, 230.0));
    }
    std::uint8_t* out = pixels(tick, camera);
    for (std::size_t i = 0; i < image.size(); ++i) out[i] = grey(image[i] + noise_[next() >> 50]);
  }

  SceneOptions options_;
  std::size_t frame_bytes_, memory_bytes_;
  std::unique_ptr<std::byte, decltype(&std::free)> memory_;
  std::uint64_t random_;
  std::vector<float> noise_;
  std::vector<std::vector<std::uint8_t>> backgrounds_, limits_;
};

}  // namespace glint::benchmarks
