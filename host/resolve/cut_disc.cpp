// SPDX-License-Identifier: MIT
// Rings of the profile, added up for many radii and limits.
#include "host/resolve/cut_disc.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace glint {
namespace {

constexpr double kRowStep = 0.25, kFirstRow = 0.25;  // radii in sigma
constexpr std::size_t kRows = 120;

/// Over rings out to where the profile falls below the limit.
CutDisc cut(const DiscProfile& profile, double limit) noexcept {
  constexpr int kRings = 64;
  const double step = static_cast<double>(profile.reach_px()) / kRings;
  CutDisc sum;
  double inner = 0.0, second = 0.0;
  double above_inner = static_cast<double>(profile.at(0.0f).share) - limit;
  for (int i = 1; i <= kRings && above_inner > 0.0; ++i) {
    double outer = step * i;
    double above = static_cast<double>(profile.at(static_cast<float>(outer)).share) - limit;
    if (above < 0.0) {
      outer = inner + (outer - inner) * above_inner / (above_inner - above);
      above = 0.0;
    }
    const double middle = 0.5 * (inner + outer), ring = 2.0 * std::numbers::pi * middle * (outer - inner);
    const double light = 0.5 * (above_inner + above) * ring;
    sum.area_px2 += ring;
    sum.light_px2 += light;
    second += light * (middle * middle + (outer - inner) * (outer - inner) / 12.0);
    inner = outer, above_inner = above;
  }
  if (sum.light_px2 > 0.0) sum.second_moment_px2 = 0.5 * second / sum.light_px2;
  return sum;
}

}  // namespace

CutDiscs::CutDiscs(const DiscProfiles& profiles) : sigma_px_(profiles.sigma_px()), rows_(kRows) {
  for (std::size_t n = 0; n < kRows; ++n) {
    const DiscProfile profile = profiles.of(sigma_px_ * (kFirstRow + kRowStep * static_cast<double>(n)));
    for (std::size_t k = 0; k < kLimits; ++k) {
      const double root = static_cast<double>(k) / (kLimits - 1);
      const CutDisc left = cut(profile, root * root);
      rows_[n][k] = {static_cast<float>(std::sqrt(left.area_px2)),
                     static_cast<float>(std::sqrt(left.light_px2)),
                     static_cast<float>(std::sqrt(left.second_moment_px2))};
    }
  }
}

CutDisc CutDiscs::of(double radius_px, double limit) const noexcept {
  if (!(limit < 1.0 - std::exp(-0.5 * radius_px * radius_px / (sigma_px_ * sigma_px_)))) return {};
  const double row = (radius_px / sigma_px_ - kFirstRow) / kRowStep;
  const double column = std::sqrt(std::max(0.0, limit)) * (kLimits - 1);
  const auto n = static_cast<std::size_t>(std::clamp(row, 0.0, static_cast<double>(kRows - 2)));
  const auto k = std::min(static_cast<std::size_t>(column), kLimits - 2);
  // Beyond the last row lengths go on growing as they did: the blurred rim keeps its width.
  const double down = std::max(row - static_cast<double>(n), 0.0), right = column - static_cast<double>(k);
  const auto length = [&](float Node::*which) {
    const auto at = [&](std::size_t i, std::size_t j) { return static_cast<double>(rows_[i][j].*which); };
    const double above = at(n, k) + right * (at(n, k + 1) - at(n, k));
    const double below = at(n + 1, k) + right * (at(n + 1, k + 1) - at(n + 1, k));
    return above + down * (below - above);
  };
  const double area = length(&Node::area), light = length(&Node::light), moment = length(&Node::moment);
  return {area * area, light * light, moment * moment};
}

}  // namespace glint
