// SPDX-License-Identifier: MIT
// Calibration as JSON: {"cameras": [{"camera", "size", "K", "dist_k1k2p1p2k3", "R", "t_mm"}]}, X_cam = R
// X_world + t.
#include <nlohmann/json.hpp>

#include "host/base/error.hpp"
#include "host/config/raw_calibration.hpp"

namespace glint {
namespace {

using Json = nlohmann::json;

/// One JSON object and its path in the file ("calibration.json: cameras[0]"), which is all that the parser
/// keeps.
struct Place {
  const Json& object;
  std::string where;

  const Json& at(const char* key) const {
    const auto found = object.find(key);
    if (found == object.end()) throw Error(where + ": \"" + key + "\" is missing");
    return *found;
  }
};

std::vector<double> numbers_in(const Json& array, const std::string& where) {
  if (!array.is_array()) throw Error(where + ": must be an array of numbers");
  std::vector<double> values;
  for (const Json& element : array) {
    if (!element.is_number()) throw Error(where + ": must hold numbers only");
    values.push_back(element.get<double>());
  }
  return values;
}

Eigen::Matrix3d matrix_in(const Json& rows, const std::string& where) {
  if (!rows.is_array() || rows.size() != 3) throw Error(where + ": must be an array of 3 rows");
  Eigen::Matrix3d matrix;
  for (int r = 0; r < 3; ++r) {
    const std::vector<double> row = numbers_in(rows[static_cast<std::size_t>(r)], where);
    if (row.size() != 3) throw Error(where + ": each row must have 3 numbers");
    for (int c = 0; c < 3; ++c) matrix(r, c) = row[static_cast<std::size_t>(c)];
  }
  return matrix;
}

/// Key and unit of the positions, the same for all cameras of an import.
struct PositionUnit {
  std::string key;
  std::optional<double> metres;
};

/// Reads t_mm, t_cm, t_m or t; the key says the unit.
void read_translation(const Place& place, RawCamera& camera, PositionUnit& position_unit) {
  struct Unit {
    const char* key;
    std::optional<double> metres;
  };
  for (const Unit& unit :
       {Unit{"t_mm", 0.001}, Unit{"t_cm", 0.01}, Unit{"t_m", 1.0}, Unit{"t", std::nullopt}}) {
    if (!place.object.contains(unit.key)) continue;
    const std::string where = place.where + "." + unit.key;
    const std::vector<double> t = numbers_in(place.at(unit.key), where);
    if (t.size() != 3) throw Error(where + ": must have 3 numbers");
    if (!position_unit.key.empty() && position_unit.key != unit.key) {
      throw Error(where + ": an earlier camera has \"" + position_unit.key +
                  "\"; all must use the same unit");
    }
    camera.translation = Eigen::Vector3d(t[0], t[1], t[2]);
    position_unit = {unit.key, unit.metres};
    return;
  }
}

RawCamera read_camera(const Place& place, PositionUnit& position_unit) {
  RawCamera camera;
  camera.where = place.where;
  for (const char* key : {"camera", "name"}) {
    if (place.object.contains(key) && place.at(key).is_string())
      camera.name = place.at(key).get<std::string>();
  }
  if (place.object.contains("size")) {
    const std::string where = place.where + ".size";
    const std::vector<double> size = numbers_in(place.at("size"), where);
    if (size.size() != 2) throw Error(where + ": must be [width, height]");
    camera.width_px = pixels_of(size[0], where);
    camera.height_px = pixels_of(size[1], where);
  }
  camera.matrix = matrix_in(place.at("K"), place.where + ".K");
  camera.distortion = numbers_in(place.at("dist_k1k2p1p2k3"), place.where + ".dist_k1k2p1p2k3");
  if (place.object.contains("R")) camera.rotation = matrix_in(place.at("R"), place.where + ".R");
  read_translation(place, camera, position_unit);
  return camera;
}

}  // namespace

RawCalibration read_json_calibration(const std::vector<InputFile>& files) {
  RawCalibration raw;
  raw.format = "JSON";
  PositionUnit position_unit;
  for (const InputFile& file : files) {
    Json root;
    try {
      root = Json::parse(file.text);
    } catch (const Json::parse_error& error) {
      throw Error(place_of(file, error.byte > 0 ? error.byte - 1 : 0) + ": not JSON");
    } catch (const Json::exception& error) {
      throw Error(file.path.string() + ": not JSON: " + error.what());
    }
    const std::string name = file.path.string();
    if (!root.is_object() || !root.contains("cameras") || !root["cameras"].is_array()) {
      throw Error(name + ": \"cameras\", an array of objects, is missing");
    }
    for (std::size_t n = 0; n < root["cameras"].size(); ++n) {
      const std::string where = name + ": cameras[" + std::to_string(n) + "]";
      if (!root["cameras"][n].is_object()) throw Error(where + ": must be an object");
      raw.cameras.push_back(read_camera({root["cameras"][n], where}, position_unit));
    }
  }
  raw.metres_per_unit = position_unit.metres;
  return raw;
}

}  // namespace glint
