// SPDX-License-Identifier: MIT
// How brightly a camera shows markers.
#pragma once

#include <cmath>

namespace glint {

/// Brightness of markers by the radius of their images, learnt from markers that were seen well. It goes with
/// a power of the nearness: with the square of it for a point-like lamp, with less where lamps are large or
/// far from the camera. A median regression by steps of the sign of the error, which does not mind the few
/// that are not what they were taken for.
class UsualBrightness {
 public:
  void learn(double grey, double radius_px) noexcept {
    if (!(grey > 0.0) || !(radius_px > 0.0)) return;
    if (seen_ == 0) log_grey_ = std::log(grey) - power_ * log_size(radius_px);
    const double step = std::copysign(kStep, std::log(grey) - log_grey(radius_px));
    log_grey_ += step;
    power_ += step * log_size(radius_px);
    if (seen_ < kEnough) ++seen_;
  }

  /// Level inside, above the dark, of a marker of this radius; 0: not known yet.
  double grey(double radius_px) const noexcept {
    return seen_ < kEnough || !(radius_px > 0.0) ? 0.0 : std::exp(log_grey(radius_px));
  }

 private:
  static constexpr double kStep = 0.005, kMiddle_px = 2.0;
  static constexpr unsigned kEnough = 30;

  static double log_size(double radius_px) noexcept { return std::log(radius_px / kMiddle_px); }
  double log_grey(double radius_px) const noexcept { return log_grey_ + power_ * log_size(radius_px); }

  double log_grey_ = 0.0, power_ = 1.5;
  unsigned seen_ = 0;
};

}  // namespace glint
