// SPDX-License-Identifier: MIT
// Results as a table for other programs.
#pragma once

#include <string>

#include "host/bench/compare.hpp"
#include "host/bench/results.hpp"

namespace glint::bench {

/// One row per device, scene and quantity. Series have count and quantiles, single figures a value. A device
/// that is wrong has one row per scene, without figures. Texts are quoted as RFC 4180 asks.
std::string to_csv(const Results& results, const Baseline* baseline = nullptr);

}  // namespace glint::bench
