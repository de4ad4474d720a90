// SPDX-License-Identifier: MIT
// glint's detectors as contenders, and the floor below all of them.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "benchmarks/contender.hpp"
#include "gpu/detector.hpp"
#include "host/bench/scene.hpp"

namespace glint::benchmarks {

using bench::Scene;
using bench::SceneOptions;

struct NamedDetector {
  std::string name;
  std::shared_ptr<gpu::Detector> detector;  // with its limits set
};

/// Native on one and two threads, and every usable Vulkan device.
std::vector<NamedDetector> glint_detectors(Scene& scene);

Contender as_contender(const Scene& scene, const NamedDetector& detector);

/// Nothing but reading every pixel once.
std::vector<Contender> memory_floor(const Scene& scene);

}  // namespace glint::benchmarks
