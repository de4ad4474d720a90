// SPDX-License-Identifier: MIT
// Blurred filled shapes by integration along the outline.
#include "host/sim/blur.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/base/check.hpp"

namespace glint::sim {
namespace {

constexpr int kPhases = 128;
constexpr unsigned kMaxTaps = 64;

double normal_cdf(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }
/// Integral of the normal distribution function.
double normal_cdf_integral(double x) {
  return x * normal_cdf(x) + std::exp(-0.5 * x * x) / std::sqrt(2.0 * std::numbers::pi);
}

}  // namespace

BlurKernel::BlurKernel(double sigma_px)
    : reach_(static_cast<int>(std::ceil(4.0 * sigma_px + 0.5))),
      taps_(static_cast<unsigned>(2 * reach_ + 2)) {
  GLINT_CHECK(sigma_px > 0.0 && taps_ <= kMaxTaps);
  for (int phase = 0; phase <= kPhases; ++phase) {
    for (unsigned j = 0; j < taps_; ++j) {
      const double t = static_cast<int>(j) - reach_ - static_cast<double>(phase) / kPhases;
      point_.push_back(
          static_cast<float>(normal_cdf((t + 0.5) / sigma_px) - normal_cdf((t - 0.5) / sigma_px)));
      edge_.push_back(static_cast<float>(sigma_px * (normal_cdf_integral((t + 0.5) / sigma_px) -
                                                     normal_cdf_integral((t - 0.5) / sigma_px))));
    }
  }
}

int BlurKernel::respond(double position_px, float* point, float* edge) const noexcept {
  const double whole = std::floor(position_px);
  const double phase = (position_px - whole) * kPhases;
  const auto cell = std::min(static_cast<std::size_t>(phase), static_cast<std::size_t>(kPhases - 1));
  const auto far = static_cast<float>(phase - static_cast<double>(cell));
  const float* p = point_.data() + cell * taps_;
  const float* e = edge_.data() + cell * taps_;
  for (unsigned j = 0; j < taps_; ++j) point[j] = p[j] + far * (p[j + taps_] - p[j]);
  if (edge != nullptr)
    for (unsigned j = 0; j < taps_; ++j) edge[j] = e[j] + far * (e[j + taps_] - e[j]);
  return static_cast<int>(whole);
}

Patch::Patch() {
  constexpr std::size_t kSide_px = 64;
  for (std::vector<float>* values : {&signal_, &by_x_, &by_y_}) values->reserve(kSide_px * kSide_px);
  edge_row_.reserve(kSide_px);
}

void Patch::reset(int x_min_px, int y_min_px, int x_max_px, int y_max_px, bool with_gradient) {
  x_min_ = x_min_px;
  y_min_ = y_min_px;
  width_ = std::max(0, x_max_px - x_min_px + 1);
  height_ = std::max(0, y_max_px - y_min_px + 1);
  gradient_ = with_gradient;
  const std::size_t pixels = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  signal_.assign(pixels, 0.0f);
  edge_row_.assign(static_cast<std::size_t>(width_), 0.0f);
  if (with_gradient) {
    by_x_.assign(pixels, 0.0f);
    by_y_.assign(pixels, 0.0f);
  }
}

void Patch::add_filled(const BlurKernel& kernel, std::span<const OutlinePoint> outline, double orientation,
                       double grey) {
  const int taps = static_cast<int>(kernel.taps());
  float column_point[kMaxTaps], row_point[kMaxTaps], row_edge[kMaxTaps];
  for (const OutlinePoint& p : outline) {
    const int x_first = kernel.respond(p.x_px, row_point, row_edge) - kernel.reach() - x_min_;
    const int y_first = kernel.respond(p.y_px, column_point, nullptr) - kernel.reach() - y_min_;
    // Left of the taps the edge response is 0, right of them 1.
    const int x_begin = std::clamp(x_first, 0, width_),
              x_taps_end = std::clamp(x_first + taps, x_begin, width_);
    for (int x = x_begin; x < x_taps_end; ++x) edge_row_[static_cast<std::size_t>(x)] = row_edge[x - x_first];
    for (int x = x_taps_end; x < width_; ++x) edge_row_[static_cast<std::size_t>(x)] = 1.0f;
    const auto dx = static_cast<float>(orientation * grey * p.dx_px);
    const auto dy = static_cast<float>(-orientation * grey * p.dy_px);
    const int y_end = std::min(y_first + taps, height_);
    for (int y = std::max(y_first, 0); y < y_end; ++y) {
      const float weight = column_point[y - y_first];
      float* signal = signal_.data() + offset(y);
      const float signal_weight = weight * dy;
      for (int x = x_begin; x < width_; ++x)
        signal[x] += signal_weight * edge_row_[static_cast<std::size_t>(x)];
      if (!gradient_) continue;
      float* by_x = by_x_.data() + offset(y);
      float* by_y = by_y_.data() + offset(y);
      for (int x = x_begin; x < x_taps_end; ++x) {
        by_x[x] += weight * dy * row_point[x - x_first];
        by_y[x] += weight * dx * row_point[x - x_first];
      }
    }
  }
}

void Patch::add_point(const BlurKernel& kernel, double x_px, double y_px, double grey) {
  const int taps = static_cast<int>(kernel.taps());
  float column_point[kMaxTaps], row_point[kMaxTaps];
  const int x_first = kernel.respond(x_px, row_point, nullptr) - kernel.reach() - x_min_;
  const int y_first = kernel.respond(y_px, column_point, nullptr) - kernel.reach() - y_min_;
  const int x_begin = std::max(x_first, 0), x_end = std::min(x_first + taps, width_);
  const int y_end = std::min(y_first + taps, height_);
  for (int y = std::max(y_first, 0); y < y_end; ++y) {
    const float weight = static_cast<float>(grey) * column_point[y - y_first];
    float* signal = signal_.data() + offset(y);
    for (int x = x_begin; x < x_end; ++x) signal[x] += weight * row_point[x - x_first];
  }
}

}  // namespace glint::sim
