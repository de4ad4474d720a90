// SPDX-License-Identifier: MIT
// Results as Markdown tables, to be pasted into an issue.
#pragma once

#include <string>

#include "host/bench/compare.hpp"
#include "host/bench/results.hpp"

namespace glint::bench {

/// With a `baseline`, columns say how the medians of `wall` have changed.
std::string to_markdown(const Results& results, const Baseline* baseline = nullptr);

}  // namespace glint::bench
