// SPDX-License-Identifier: MIT
// Every device on every scene.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "host/bench/results.hpp"
#include "host/bench/targets.hpp"

namespace glint::bench {

struct SuiteOptions {
  std::vector<Target> targets;
  std::vector<SceneKey> scenes;
  Conditions conditions;
  unsigned threads = 2;                   ///< of the CPU detector
  std::vector<double> headline_rates_hz;  ///< empty: no headline
};

/// Where it is: "llvmpipe ...: 4 x 1280x800, 20 blobs".
using Progress = std::function<void(const std::string&)>;

/// That all pictures of the scenes can be drawn and are within what a detector keeps. Throws Error.
void check_scenes(const std::vector<SceneKey>& scenes);

/// Runs all of it: devices are checked on each scene first, and get figures only if they are right. What goes
/// wrong with one device is in its rows; the others go on. Throws only what concerns all, such as no memory
/// for the pictures. Fills in everything but the names of versions.
Results run_suite(const SuiteOptions& options, const Progress& progress);

}  // namespace glint::bench
