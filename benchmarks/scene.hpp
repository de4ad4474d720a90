// SPDX-License-Identifier: MIT
// The pictures of `glint bench`, under the names that this folder uses.
#pragma once

#include "host/bench/scene.hpp"

namespace glint::benchmarks {

using bench::Scene;
using bench::SceneOptions;

}  // namespace glint::benchmarks
