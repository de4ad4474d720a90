// SPDX-License-Identifier: MIT
// Mean background and its noise frames.
#include "host/sim/backdrop.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/sim/blur.hpp"

namespace glint::sim {
namespace {

// Fixed pattern: black level, stray light and this are 8 to 14 grey in all, as on real recordings.
constexpr float kColumnPattern_grey = 0.4f, kPixelPattern_grey = 0.5f;

}  // namespace

NoiseModel::NoiseModel(const SimOptions& options)
    : black_grey(static_cast<float>(options.sensor.black_level_grey)),
      grey_per_electron(
          static_cast<float>((255.0 - options.sensor.black_level_grey) / options.sensor.full_well_e)) {
  const double read = options.sensor.read_noise_e * static_cast<double>(grey_per_electron);
  const double extra = options.faults.extra_noise_grey;
  dark_variance_grey2 = static_cast<float>(read * read + extra * extra);
}

Backdrop::Backdrop(const Scene& scene, std::uint32_t camera, const NoiseModel& noise,
                   const NormalTable& normal)
    : width_(scene.options().width_px),
      height_(scene.options().height_px),
      stripe_rows_((height_ + kStripes - 1) / kStripes),
      seed_(stream_seed(scene.options().seed, Stream::DarkNoise, camera)) {
  const std::size_t pixels = std::size_t{width_} * height_;
  std::vector<float> mean(pixels);
  Random pattern(stream_seed(scene.options().seed, Stream::Pattern, camera));
  std::vector<float> column(width_);
  for (float& value : column) value = kColumnPattern_grey * normal.draw(pattern);
  const Glow& glow = scene.glow(camera);
  for (std::uint32_t y = 0; y < height_; ++y) {
    for (std::uint32_t x = 0; x < width_; ++x) {
      mean[std::size_t{y} * width_ + x] = noise.black_grey + static_cast<float>(glow.grey_at(x, y)) +
                                          column[x] + kPixelPattern_grey * normal.draw(pattern);
    }
  }
  paint_spots(scene, camera, mean);
  mean_.resize(pixels);
  std::transform(mean.begin(), mean.end(), mean_.begin(), [](float grey) {
    return static_cast<std::uint16_t>(std::clamp(grey, 0.0f, 511.0f) / kMeanStep + 0.5f);
  });
  for (std::uint32_t frame = 0; frame < kFrames; ++frame) {
    frames_[frame].resize(pixels);
    Random random(stream_seed(seed_, Stream::DarkNoise, frame));
    for (std::size_t i = 0; i < pixels; ++i) {
      const float grey = static_cast<float>(mean_[i]) * kMeanStep;
      frames_[frame][i] = to_pixel(grey + std::sqrt(noise.variance_grey2(grey)) * normal.draw(random));
    }
  }
}

void Backdrop::paint_spots(const Scene& scene, std::uint32_t camera, std::vector<float>& mean) const {
  const BlurKernel kernel(scene.options().sensor.psf_sigma_px);
  Patch patch;
  for (const BrightSpot& spot : scene.spots(camera)) {
    std::array<OutlinePoint, 128> circle;
    const double step = 2.0 * std::numbers::pi / circle.size();
    for (std::size_t i = 0; i < circle.size(); ++i) {
      const double c = std::cos(step * static_cast<double>(i)), s = std::sin(step * static_cast<double>(i));
      circle[i] = {spot.x_px + spot.radius_px * c, spot.y_px + spot.radius_px * s, -spot.radius_px * s * step,
                   spot.radius_px * c * step};
    }
    const double reach = spot.radius_px + kernel.reach() + 1.0;
    patch.reset(static_cast<int>(std::max(0.0, std::floor(spot.x_px - reach))),
                static_cast<int>(std::max(0.0, std::floor(spot.y_px - reach))),
                static_cast<int>(std::min(width_ - 1.0, std::ceil(spot.x_px + reach))),
                static_cast<int>(std::min(height_ - 1.0, std::ceil(spot.y_px + reach))), false);
    patch.add_filled(kernel, circle, 1.0, spot.grey);
    for (int y = 0; y < patch.height_px(); ++y) {
      const std::size_t row = static_cast<std::size_t>(patch.y_min_px() + y) * width_;
      for (int x = 0; x < patch.width_px(); ++x) {
        mean[row + static_cast<std::size_t>(patch.x_min_px() + x)] += patch.row(y)[x];
      }
    }
  }
}

}  // namespace glint::sim
