// SPDX-License-Identifier: MIT
// Results as a Markdown page and as JSON.
#pragma once

#include <span>
#include <string>

#include "benchmarks/identity/run_scene.hpp"

namespace glint::identity {

/// The page: goals with median and worst over the seeds beside those of the plain method, then all figures.
std::string results_markdown(std::span<const SceneRun> runs);
/// One object a run, with every figure of both trackers in SI units (infinity: null).
std::string results_json(std::span<const SceneRun> runs);
/// All figures of one result, one a line, for the terminal.
std::string result_lines(const IdentityResult& result);
/// "markers-20 seed 3: recall 0.99990, ..." for a run that goes on.
std::string progress_line(const SceneRun& run);

}  // namespace glint::identity
