// SPDX-License-Identifier: MIT
// What takes part in a comparison.
#pragma once

#include <functional>
#include <string>

namespace glint::benchmarks {

/// One way to find the blobs of a frame set.
struct Contender {
  std::string name;
  /// Works through one tick of the scene and returns how many blobs it found in all cameras.
  std::function<std::size_t(unsigned tick)> run;
};

}  // namespace glint::benchmarks
