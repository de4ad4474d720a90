// SPDX-License-Identifier: MIT
// How one finds blobs with OpenCV: as the thesis did, the same without its waste, and as lean as it goes.
#pragma once

#include <vector>

#include "benchmarks/contender.hpp"
#include "host/bench/scene.hpp"

namespace glint::benchmarks {

using bench::Scene;
using bench::SceneOptions;

/// Each on one thread, and with its cameras shared out to two. The scene must outlive them.
std::vector<Contender> opencv_contenders(const Scene& scene);

}  // namespace glint::benchmarks
