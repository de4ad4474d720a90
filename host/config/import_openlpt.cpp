// SPDX-License-Identifier: MIT
// OpenLPT camera text files: "# Title:" lines, each followed by rows of numbers; millimetres; X_cam = R
// X_world + t.
#include <map>
#include <sstream>

#include "host/base/error.hpp"
#include "host/config/number_text.hpp"
#include "host/config/raw_calibration.hpp"

namespace glint {
namespace {

struct Block {
  std::size_t line = 0;  ///< of the title
  std::vector<std::string> rows;
};

/// Blocks by title, without what follows in parentheses or after the colon.
std::map<std::string, Block> read_blocks(const InputFile& file) {
  std::map<std::string, Block> blocks;
  Block* current = nullptr;
  std::istringstream lines(file.text);
  std::size_t number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty()) continue;
    if (line[0] == '#') {
      const auto first = line.find_first_not_of("# ");
      std::string title = first == std::string::npos ? "" : line.substr(first);
      title = title.substr(0, title.find(':'));
      current = &blocks[title];
      *current = Block{number, {}};
    } else if (current) {
      current->rows.push_back(line);
    }
  }
  return blocks;
}

class Reader {
 public:
  explicit Reader(const InputFile& file) : file_(file), blocks_(read_blocks(file)) {}

  bool has(const std::string& title) const { return blocks_.count(title) > 0; }

  std::string where(const std::string& title) const {
    const auto found = blocks_.find(title);
    return file_.path.string() + ":" + std::to_string(found == blocks_.end() ? 1 : found->second.line) + ":1";
  }

  const Block& block(const std::string& title) const {
    const auto found = blocks_.find(title);
    if (found == blocks_.end()) throw Error(where(title) + ": the part \"# " + title + ":\" is missing");
    return found->second;
  }

  /// All numbers of a block. `count` 0: any number of them.
  std::vector<double> numbers(const std::string& title, std::size_t count) const {
    const Block& found = block(title);
    std::vector<double> values;
    for (std::size_t r = 0; r < found.rows.size(); ++r) {
      std::istringstream row(found.rows[r]);
      for (std::string field; std::getline(row, field, ',');) {
        const auto value = parse_number(field);
        if (!value) {
          throw Error(file_.path.string() + ":" + std::to_string(found.line + 1 + r) + ":1: \"" + field +
                      "\" is not a number");
        }
        values.push_back(*value);
      }
    }
    if (count > 0 && values.size() != count) {
      throw Error(where(title) + ": " + title + " must have " + std::to_string(count) + " numbers, not " +
                  std::to_string(values.size()));
    }
    return values;
  }

  Eigen::Matrix3d matrix(const std::string& title) const {
    const std::vector<double> values = numbers(title, 9);
    return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(values.data());
  }

  Eigen::Vector3d vector(const std::string& title) const {
    const std::vector<double> values = numbers(title, 3);
    return Eigen::Map<const Eigen::Vector3d>(values.data());
  }

 private:
  const InputFile& file_;
  std::map<std::string, Block> blocks_;
};

/// The rotation stands in the file three times, rounded differently: the inverse matrix and the vector carry
/// all digits, the matrix six. They must agree.
Eigen::Matrix3d read_rotation(const Reader& reader) {
  const Eigen::Matrix3d coarse = reader.matrix("Rotation Matrix");
  Eigen::Matrix3d fine = coarse;
  if (reader.has("Rotation Vector")) fine = rotation_of_vector(reader.vector("Rotation Vector"));
  if (!((fine - coarse).cwiseAbs().maxCoeff() <= 1e-3)) {
    throw Error(reader.where("Rotation Matrix") +
                ": rotation matrix and rotation vector contradict each other");
  }
  return fine;
}

RawCamera read_camera(const InputFile& file) {
  const Reader reader(file);
  RawCamera camera;
  camera.where = file.path.string();
  const Block& model = reader.block("Camera Model");
  if (model.rows.empty() || model.rows[0] != "PINHOLE") {
    throw Error(reader.where("Camera Model") + ": the camera model is " +
                (model.rows.empty() ? "missing" : model.rows[0]) + "; only PINHOLE can be converted");
  }
  const std::vector<double> size = reader.numbers("Image Size", 2);
  camera.height_px = pixels_of(size[0], reader.where("Image Size"));
  camera.width_px = pixels_of(size[1], reader.where("Image Size"));
  camera.matrix = reader.matrix("Camera Matrix");
  camera.distortion = reader.numbers("Distortion Coefficients", 0);
  camera.rotation = read_rotation(reader);
  camera.translation = reader.vector("Translation Vector");
  if (reader.has("Camera Calibration Error")) {
    const Block& error = reader.block("Camera Calibration Error");
    const auto value = error.rows.empty() ? std::nullopt : parse_number(error.rows[0]);
    if (value) camera.rms_px = *value;  // "None" otherwise
  }
  return camera;
}

}  // namespace

RawCalibration read_openlpt_calibration(const std::vector<InputFile>& files) {
  RawCalibration raw;
  raw.format = "OpenLPT";
  raw.metres_per_unit = 0.001;
  for (const InputFile& file : files) raw.cameras.push_back(read_camera(file));
  return raw;
}

}  // namespace glint
