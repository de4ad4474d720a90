// SPDX-License-Identifier: MIT
// Results as JSON, complete, and back.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "host/bench/compare.hpp"
#include "host/bench/results.hpp"

namespace glint::bench {

inline constexpr const char* kSchemaName = "glint-bench";
inline constexpr unsigned kSchemaVersion = 1;

/// Two spaces of indentation, arrays of numbers in one line. Without `samples` only summaries. With a
/// `baseline` there is a list "comparison" at the end.
std::string to_json(const Results& results, bool samples, const Baseline* baseline = nullptr);

/// Reads what to_json() wrote. `name` is for messages. Throws Error that names it and what is wrong, with the
/// place: "old.json: devices[0].rows[2].wall: no key \"p50_s\"".
Results parse_results(std::string_view json, const std::string& name);

/// Throws Error, also if the file cannot be read.
Results read_results(const std::filesystem::path& file);

}  // namespace glint::bench
