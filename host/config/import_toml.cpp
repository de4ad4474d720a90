// SPDX-License-Identifier: MIT
// Calibrations of aniposelib ([cam_0], Rodrigues vector, unit of its board) and caliscope ([cameras.0] or
// [cam_0], rotation matrix or vector, metres). Both are camera_from_world: X_cam = R X_world + t.
#include <algorithm>
#include <utility>

#include "host/base/error.hpp"
#include "host/config/raw_calibration.hpp"
#include "host/config/toml_section.hpp"

namespace glint {
namespace {

struct Found {
  std::string key;
  const toml::table* table;
};

class Reader {
 public:
  explicit Reader(const InputFile& file) : file_(file) {}

  std::string where(const toml::node& node) const {
    const toml::source_position at = node.source().begin;
    return file_.path.string() + ":" + std::to_string(at.line) + ":" + std::to_string(at.column);
  }

  const toml::node& need(const Found& camera, const char* key) const {
    const toml::node* node = camera.table->get(key);
    if (!node) throw Error(where(*camera.table) + ": " + camera.key + " lacks \"" + key + "\"");
    return *node;
  }

  std::vector<double> numbers(const toml::node& node) const {
    const toml::array* array = node.as_array();
    if (!array) throw Error(where(node) + ": must be an array of numbers");
    std::vector<double> values;
    for (const toml::node& element : *array) {
      const auto value = element.is_number() ? element.value<double>() : std::nullopt;
      if (!value) throw Error(where(element) + ": must be a number");
      values.push_back(*value);
    }
    return values;
  }

  Eigen::Vector3d vector(const toml::node& node) const {
    const std::vector<double> values = numbers(node);
    if (values.size() != 3) throw Error(where(node) + ": must have 3 numbers");
    return {values[0], values[1], values[2]};
  }

  Eigen::Matrix3d matrix(const toml::node& node) const {
    const toml::array* rows = node.as_array();
    if (!rows || rows->size() != 3) throw Error(where(node) + ": must have 3 rows of 3 numbers");
    Eigen::Matrix3d result;
    for (int r = 0; r < 3; ++r) result.row(r) = vector((*rows)[static_cast<std::size_t>(r)]);
    return result;
  }

 private:
  const InputFile& file_;
};

bool is_matrix(const toml::node& node) {
  const toml::array* array = node.as_array();
  return array && !array->empty() && (*array)[0].is_array();
}

/// A calibration may not have got so far yet: caliscope writes "null" then.
bool is_given(const toml::node* node) {
  return node && !(node->is_string() && *node->value<std::string>() == "null");
}

RawCamera read_camera(const Reader& reader, const Found& found) {
  const toml::table& table = *found.table;
  RawCamera camera;
  camera.where = reader.where(table);
  camera.name = table["name"].value<std::string>().value_or(found.key);
  if (table["fisheye"].value<bool>().value_or(false)) {
    throw Error(reader.where(*table.get("fisheye")) + ": " + found.key +
                " has a fisheye lens model, which cannot be converted");
  }
  const std::vector<double> size = reader.numbers(reader.need(found, "size"));
  if (size.size() != 2) throw Error(reader.where(*table.get("size")) + ": must be [width, height]");
  camera.width_px = pixels_of(size[0], reader.where(*table.get("size")));
  camera.height_px = pixels_of(size[1], reader.where(*table.get("size")));
  camera.matrix = reader.matrix(reader.need(found, "matrix"));
  camera.distortion = reader.numbers(reader.need(found, "distortions"));
  if (is_given(table.get("rotation"))) {
    const toml::node& rotation = *table.get("rotation");
    camera.rotation =
        is_matrix(rotation) ? reader.matrix(rotation) : rotation_of_vector(reader.vector(rotation));
  }
  if (is_given(table.get("translation"))) camera.translation = reader.vector(*table.get("translation"));
  camera.rms_px = table["error"].value<double>().value_or(0.0);
  return camera;
}

/// All camera tables, in the order of the file (the parser sorts by key, so that cam_10 comes before cam_2).
std::vector<Found> find_cameras(const toml::table& root) {
  std::vector<Found> cameras;
  for (const auto& [key, node] : root) {
    const std::string name(key.str());
    if (name == "cameras" && node.is_table()) {
      for (const auto& [number, camera] : *node.as_table()) {
        if (camera.is_table()) cameras.push_back({"cam_" + std::string(number.str()), camera.as_table()});
      }
    } else if (name.rfind("cam_", 0) == 0 && node.is_table()) {
      cameras.push_back({name, node.as_table()});
    }
  }
  std::sort(cameras.begin(), cameras.end(), [](const Found& a, const Found& b) {
    return a.table->source().begin.line < b.table->source().begin.line;
  });
  return cameras;
}

/// caliscope's tables show themselves by their key or by a matrix where aniposelib has a vector.
bool looks_like_caliscope(const toml::table& root, const std::vector<Found>& cameras) {
  if (root["cameras"].is_table()) return true;
  return std::any_of(cameras.begin(), cameras.end(), [](const Found& camera) {
    const toml::node* rotation = camera.table->get("rotation");
    return camera.table->contains("cam_id") || (rotation && is_matrix(*rotation));
  });
}

}  // namespace

RawCalibration read_toml_calibration(const std::vector<InputFile>& files, std::optional<bool> caliscope) {
  RawCalibration raw;
  for (const InputFile& file : files) {
    FileProblems problems(file.path);
    const auto root = parse_toml(file.text, problems);
    throw_problems(problems.lines());
    if (root->contains("camera") && root->contains("format")) {
      throw Error(file.path.string() + ": is a calibration file of glint already; use it as it is");
    }
    const std::vector<Found> cameras = find_cameras(*root);
    if (cameras.empty()) {
      throw Error(file.path.string() + ":1:1: no camera in it: neither [cam_0] nor [cameras.0]");
    }
    const bool in_metres = caliscope.value_or(looks_like_caliscope(*root, cameras));
    raw.format = in_metres ? "caliscope" : "aniposelib";
    if (in_metres) raw.metres_per_unit = 1.0;
    const Reader reader(file);
    for (const Found& found : cameras) {
      if ((*found.table)["ignore"].value<bool>().value_or(false)) {
        raw.notes.push_back(file.path.string() + ": " + found.key + " is marked \"ignore\" and left out");
        continue;
      }
      raw.cameras.push_back(read_camera(reader, found));
    }
  }
  return raw;
}

}  // namespace glint
