// SPDX-License-Identifier: MIT
// What a track learns of its marker's images: where each camera shows it other than its calibration says, and
// how bright it is. calibration_px2, everywhere: by camera, per axis, the variance of what the calibration
// errs by.
#pragma once

#include <span>

#include "host/match/matcher.hpp"
#include "host/track/track.hpp"

namespace glint {

/// As a marker moves on, what was learnt of the views where it was says less.
void forget_bias(Track& track, double seconds, std::span<const double> calibration_px2) noexcept;

/// From a point that the track was just corrected by.
void learn_bias(Track& track, const Point& point, std::span<const double> calibration_px2) noexcept;

/// What a calibration errs by is nearly the same a hand's breadth away: takes from `tracks` (`track` may be
/// one of them) what a neighbour knows better.
void ask_neighbours(Track& track, std::span<const Track> tracks,
                    std::span<const double> calibration_px2) noexcept;

/// By a small step for each point: one sliver must not make a marker dull.
void learn_brightness(Track& track, const Point& point) noexcept;

}  // namespace glint
