// SPDX-License-Identifier: MIT
// Made-up results with something of everything.
#pragma once

#include "host/bench/results.hpp"

namespace glint::bench::test {

/// A software Vulkan device with two right scenes, a GPU that is wrong, and the CPU that broke down on one.
Results sample_results();

/// `count` samples around `median_s`, spread evenly over +-`spread_s`.
Series series_around(double median_s, double spread_s, std::size_t count = 101);

}  // namespace glint::bench::test
