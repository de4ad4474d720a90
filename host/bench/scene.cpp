// SPDX-License-Identifier: MIT
// Draws the pictures.
#include "host/bench/scene.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string>

#include "host/base/error.hpp"

namespace glint::bench {
namespace {

constexpr std::size_t kPage = 4096;
constexpr std::uint32_t kStrideMultiple = 16, kRowMultiple = 8;  // as the frames of a live run lie
constexpr unsigned kNoiseBits = 14;
constexpr double kLargestDisc_px = 40.0, kGap_px = 4.0;

std::uint8_t grey(float v) noexcept {
  // As std::lround, without the call: adding a half to a float is exact in double.
  const double half_up = static_cast<double>(std::clamp(v, 0.0f, 255.0f)) + 0.5;
  return static_cast<std::uint8_t>(half_up);
}

}  // namespace

void Scene::Free::operator()(std::byte* memory) const noexcept { std::free(memory); }

Scene::Scene(const SceneOptions& options)
    : options_(options),
      drawn_(std::clamp(options.drawn_cameras, 1u, std::max(1u, options.cameras))),
      stride_bytes_((options.width_px + kStrideMultiple - 1) / kStrideMultiple * kStrideMultiple),
      frame_bytes_((std::size_t{stride_bytes_} * ((options.height_px + kRowMultiple - 1) / kRowMultiple) *
                        kRowMultiple +
                    kPage - 1) /
                   kPage * kPage),
      memory_bytes_(frame_bytes_ * options.cameras * options.ticks),
      random_(options.seed * 0x9e3779b97f4a7c15u + 1) {
  if (options.width_px < 64 || options.height_px < 64) {
    throw Error("pictures of " + std::to_string(options.width_px) + "x" + std::to_string(options.height_px) +
                " px: at least 64x64 px are needed");
  }
  memory_.reset(static_cast<std::byte*>(std::aligned_alloc(kPage, memory_bytes_)));
  if (!memory_) throw std::bad_alloc();
  std::memset(memory_.get(), 0, memory_bytes_);  // the padding, too, is the same everywhere
  make_noise_table();
  for (unsigned camera = 0; camera < drawn_; ++camera) {
    const std::vector<float> room = make_room();
    backgrounds_.emplace_back(room.size());
    std::transform(room.begin(), room.end(), backgrounds_.back().begin(), [](float v) { return grey(v); });
    limits_.emplace_back(room.size());
    std::transform(room.begin(), room.end(), limits_.back().begin(),
                   [&](float v) { return grey(std::round(v) + static_cast<float>(options_.margin)); });
    for (unsigned tick = 0; tick < options.ticks; ++tick) draw(tick, camera, room);
  }
  for (unsigned camera = drawn_; camera < options.cameras; ++camera) {
    for (unsigned tick = 0; tick < options.ticks; ++tick)
      std::memcpy(pixels(tick, camera), pixels(tick, camera % drawn_), frame_bytes_);
  }
}

std::uint8_t* Scene::pixels(unsigned tick, unsigned camera) const noexcept {
  const std::size_t frame = std::size_t{tick} * options_.cameras + camera;
  return reinterpret_cast<std::uint8_t*>(memory_.get()) + frame * frame_bytes_;
}

std::vector<gpu::ImageView> Scene::images(unsigned tick) const {
  std::vector<gpu::ImageView> result;
  for (unsigned camera = 0; camera < options_.cameras; ++camera) {
    result.push_back({pixels(tick, camera), options_.width_px, options_.height_px, stride_bytes_,
                      gpu::PixelFormat::Grey8});
  }
  return result;
}

std::vector<gpu::CameraFormat> Scene::formats() const {
  gpu::CameraFormat format{options_.width_px, options_.height_px, {}};
  const double scale = options_.width_px / 1280.0;
  format.lens = {914.0 * scale,
                 914.0 * scale,
                 0.5 * options_.width_px,
                 0.5 * options_.height_px,
                 {-0.32, 0.12, 0.0006, -0.0004, -0.015}};
  return std::vector<gpu::CameraFormat>(options_.cameras, format);
}

std::uint64_t Scene::next() noexcept {  // xorshift64*, Vigna 2016
  random_ ^= random_ >> 12;
  random_ ^= random_ << 25;
  random_ ^= random_ >> 27;
  return random_ * 0x2545f4914f6cdd1du;
}

double Scene::uniform(double from, double to) noexcept {
  return from + (to - from) * static_cast<double>(next() >> 11) * 0x1p-53;
}

/// Drawing a normal number for every pixel is slow: draw from a table of them.
void Scene::make_noise_table() {
  noise_.resize(std::size_t{1} << kNoiseBits);
  for (float& n : noise_) {
    const double radius = std::sqrt(-2.0 * std::log(uniform(1e-12, 1.0)));
    n = static_cast<float>(options_.noise_grey * radius * std::cos(uniform(0.0, 6.283185307179586)));
  }
}

std::vector<float> Scene::make_room() {
  std::vector<float> room(std::size_t{options_.width_px} * options_.height_px);
  for (float& v : room) v = 8.0f + static_cast<float>(next() % 7);
  for (int i = 0; i < 5; ++i) {
    const double d = uniform(6.0, 14.0);
    add_disc(room, uniform(20.0, options_.width_px - 20.0), uniform(20.0, options_.height_px - 20.0), d,
             uniform(150.0, 190.0));
  }
  return room;
}

void Scene::add_disc(std::vector<float>& image, double x, double y, double diameter,
                     double brightness) const {
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

void Scene::draw(unsigned tick, unsigned camera, const std::vector<float>& room) {
  std::vector<float> image = room;
  struct Disc {
    double x, y, d;
  };
  std::vector<Disc> discs;
  const auto touch = [](const Disc& a, const Disc& b) {
    const double dx = a.x - b.x, dy = a.y - b.y;
    return std::abs(dx) < kLargestDisc_px + kGap_px && std::abs(dy) < kLargestDisc_px + kGap_px &&
           std::hypot(dx, dy) < 0.5 * (a.d + b.d) + kGap_px;
  };
  for (unsigned tries = 0; discs.size() < options_.blobs_per_camera && tries < 100000; ++tries) {
    const double d = uniform(3.0, kLargestDisc_px);
    const Disc disc{uniform(24.0, options_.width_px - 24.0), uniform(24.0, options_.height_px - 24.0), d};
    if (std::any_of(discs.begin(), discs.end(), [&](const Disc& other) { return touch(other, disc); }))
      continue;
    discs.push_back(disc);
    add_disc(image, disc.x, disc.y, disc.d, uniform(120.0, 230.0));
  }
  if (discs.size() < options_.blobs_per_camera) {
    throw Error(std::to_string(options_.blobs_per_camera) + " blobs do not fit in a picture of " +
                std::to_string(options_.width_px) + "x" + std::to_string(options_.height_px) +
                " px without touching: ask for fewer blobs or larger pictures");
  }
  const float* value = image.data();
  for (std::uint32_t y = 0; y < options_.height_px; ++y) {
    std::uint8_t* row = pixels(tick, camera) + std::size_t{y} * stride_bytes_;
    for (std::uint32_t x = 0; x < options_.width_px; ++x)
      row[x] = grey(*value++ + noise_[next() >> (64 - kNoiseBits)]);
  }
}

}  // namespace glint::bench
