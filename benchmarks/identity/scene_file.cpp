// SPDX-License-Identifier: MIT
// SimOptions as JSON, and back by name.
#include "benchmarks/identity/scene_file.hpp"

#include <array>
#include <string_view>

#include <nlohmann/json.hpp>

#include "host/base/error.hpp"
#include "host/files/text_file.hpp"

namespace glint::identity {
namespace {

using Json = nlohmann::ordered_json;
constexpr std::size_t kLargestFile_bytes = 1'000'000;

std::string_view name_of(SimMotion motion) {
  constexpr std::array<std::string_view, 5> kNames{"thrown", "wand", "tumbling", "crossing", "pairs"};
  return kNames[static_cast<std::size_t>(motion)];
}

Json faults_json(const SimFaults& f) {
  Json json{{"missing_rate", f.missing_rate},
            {"blinks_per_frame", f.blinks_per_frame},
            {"drop_rate", f.drop_rate},
            {"duplicate_rate", f.duplicate_rate},
            {"late_rate", f.late_rate},
            {"extra_noise_grey", f.extra_noise_grey},
            {"off", Json::array()}};
  for (const SimOff& off : f.off)
    json["off"].push_back({{"camera", off.camera + 1}, {"tick", off.tick}, {"ticks", off.ticks}});
  return json;
}

Json settings_json(const SimOptions& o) {
  return {{"cameras", o.cameras},
          {"markers", o.markers},
          {"rate_hz", o.rate_hz},
          {"width_px", o.width_px},
          {"height_px", o.height_px},
          {"marker_radius_m", o.marker_radius_m},
          {"motion", name_of(o.motion)},
          {"max_speed_m_s", o.max_speed_m_s},
          {"wand_m", o.wand_m},
          {"person", o.person},
          {"bodies",
           {{"count", o.bodies.count},
            {"markers", o.bodies.markers},
            {"size_m", o.bodies.size_m},
            {"identical", o.bodies.identical},
            {"max_acceleration_m_s2", o.bodies.max_acceleration_m_s2},
            {"closest_m", o.bodies.closest_m},
            {"crossing_period_s", o.bodies.crossing_period_s}}},
          {"exposure_s", o.exposure_s},
          {"bright_spots", o.bright_spots},
          {"occluders", o.occluders},
          {"sensor",
           {{"full_well_e", o.sensor.full_well_e},
            {"read_noise_e", o.sensor.read_noise_e},
            {"black_level_grey", o.sensor.black_level_grey},
            {"psf_sigma_px", o.sensor.psf_sigma_px}}},
          {"jpeg_quality", o.jpeg_quality},
          {"faults", faults_json(o.faults)}};
}

}  // namespace

std::string scene_json(const ChosenScene& chosen) {
  const BenchmarkScene& scene = *chosen.scene;
  const Json json{{"benchmark", "glint identity"},
                  {"scene", scene.name},
                  {"text", scene.text},
                  {"seed", chosen.seed},
                  {"ticks", chosen.ticks},
                  {"calibration_error_px", scene.calibration_error_px},
                  {"settings", settings_json(scene.options)}};
  return json.dump(2) + "\n";
}

ChosenScene read_scene_file(const std::filesystem::path& path) {
  const std::string text = read_text_file(path, kLargestFile_bytes);
  ChosenScene chosen;
  try {
    const Json json = Json::parse(text);
    chosen.scene = &find_scene(json.at("scene").get<std::string>());
    chosen.seed = json.at("seed").get<std::uint64_t>();
    chosen.ticks = json.at("ticks").get<std::uint64_t>();
    if (json != Json::parse(scene_json(chosen))) {
      throw Error(path.string() +
                  ": was written by another version of this program, whose scene had other settings; "
                  "generate it anew");
    }
  } catch (const nlohmann::json::exception& error) {
    throw Error(path.string() + ": is no scene.json of this benchmark: " + error.what());
  } catch (const UsageError& error) {
    throw Error(path.string() + ": " + error.what());
  }
  return chosen;
}

}  // namespace glint::identity
