// SPDX-License-Identifier: MIT
// scene.json: which scene a folder holds, with every setting.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "benchmarks/identity/scenes.hpp"

namespace glint::identity {

/// A scene with its seed and length.
struct ChosenScene {
  const BenchmarkScene* scene = nullptr;
  std::uint64_t seed = 1, ticks = 0;
};

std::string scene_json(const ChosenScene& chosen);
/// The scene that a file names. Throws Error if it is no such file or if its settings are not those that this
/// program has for that scene: its truth would be another one.
ChosenScene read_scene_file(const std::filesystem::path& path);

}  // namespace glint::identity
