// SPDX-License-Identifier: MIT
// OpenCV calibrations: one camera a file with its pose, or a stereo pair (M1 D1 M2 D2 and R T, in one file or
// two). Poses are camera_from_world throughout: OpenCV's R, T and rvec, tvec take points into the (second)
// camera, and so do `extrinsics` matrices as found in the field: read the other way round, the cameras of a
// recording with known camera distances would stand 5 to 46 % wrong.
#include <array>
#include <initializer_list>
#include <utility>

#include "host/base/error.hpp"
#include "host/config/number_text.hpp"
#include "host/config/opencv_storage.hpp"
#include "host/config/raw_calibration.hpp"

namespace glint {
namespace {

/// The first of the keys that the file has.
const StorageEntry* find(const OpenCvStorage& storage, std::initializer_list<const char*> keys) {
  for (const char* key : keys) {
    const auto found = storage.find(key);
    if (found != storage.end()) return &found->second;
  }
  return nullptr;
}

const StorageMatrix& matrix_of(const StorageEntry& entry, const char* what) {
  if (!entry.matrix) throw Error(entry.where + ": " + what + " must be a matrix");
  return *entry.matrix;
}

Eigen::Matrix3d matrix3_of(const StorageEntry& entry, const char* what) {
  const StorageMatrix& m = matrix_of(entry, what);
  if (m.rows != 3 || m.cols != 3) throw Error(entry.where + ": " + what + " must be 3x3");
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(m.values.data());
}

Eigen::Vector3d vector3_of(const StorageEntry& entry, const char* what) {
  const StorageMatrix& m = matrix_of(entry, what);
  if (m.values.size() != 3) throw Error(entry.where + ": " + what + " must have 3 numbers");
  return Eigen::Map<const Eigen::Vector3d>(m.values.data());
}

/// A rotation matrix, or a Rodrigues vector.
Eigen::Matrix3d rotation_of(const StorageEntry& entry) {
  const StorageMatrix& m = matrix_of(entry, "the rotation");
  return m.values.size() == 3 ? rotation_of_vector(vector3_of(entry, "the rotation"))
                              : matrix3_of(entry, "the rotation");
}

double number_of(const StorageEntry& entry, const char* what) {
  const auto number = parse_number(entry.text);
  if (!number) throw Error(entry.where + ": " + what + " must be a number");
  return *number;
}

void read_size(const OpenCvStorage& storage, RawCamera& camera) {
  const StorageEntry* width = find(storage, {"image_width", "image_Width", "width"});
  const StorageEntry* height = find(storage, {"image_height", "image_Height", "height"});
  if (width && height) {
    camera.width_px = pixels_of(number_of(*width, "the image width"), width->where);
    camera.height_px = pixels_of(number_of(*height, "the image height"), height->where);
    return;
  }
  const StorageEntry* size = find(storage, {"image_size", "imageSize", "img_size"});
  if (!size) return;
  const StorageMatrix& m = matrix_of(*size, "the image size");
  if (m.values.size() != 2) throw Error(size->where + ": the image size must be width and height");
  camera.width_px = pixels_of(m.values[0], size->where);
  camera.height_px = pixels_of(m.values[1], size->where);
}

void refuse_other_models(const OpenCvStorage& storage) {
  const StorageEntry* model = find(storage, {"distortion_model", "camera_model"});
  if (!model) return;
  for (const char* known : {"plumb_bob", "rational_polynomial", "pinhole", "opencv", "radtan"}) {
    if (model->text == known) return;
  }
  throw Error(model->where + ": the lens model \"" + model->text +
              "\" cannot be converted; glint has OpenCV's radial-tangential one (plumb_bob)");
}

/// One camera's matrix and coefficients.
void read_lens(const StorageEntry& matrix, const StorageEntry* coefficients, RawCamera& camera) {
  camera.where = matrix.where;
  camera.matrix = matrix3_of(matrix, "the camera matrix");
  if (!coefficients) {
    throw Error(matrix.where +
                ": the distortion coefficients of this camera are missing (an ideal lens has zeros)");
  }
  camera.distortion = matrix_of(*coefficients, "the distortion").values;
}

void read_pose(const OpenCvStorage& storage, RawCamera& camera) {
  if (const StorageEntry* entry = find(storage, {"extrinsics", "camera_from_world"})) {
    const StorageMatrix& m = matrix_of(*entry, "the pose");
    const bool affine = m.rows == 4 && m.cols == 4;
    if (!affine && !(m.rows == 3 && m.cols == 4)) throw Error(entry->where + ": the pose must be 3x4 or 4x4");
    if (affine &&
        (m.values[12] != 0.0 || m.values[13] != 0.0 || m.values[14] != 0.0 || m.values[15] != 1.0)) {
      throw Error(entry->where + ": the last row of the pose must be 0 0 0 1");
    }
    const Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>> pose(m.values.data());
    camera.rotation = pose.leftCols<3>();
    camera.translation = pose.col(3);
    return;
  }
  const StorageEntry* rotation = find(storage, {"R", "rvec", "rotation"});
  const StorageEntry* translation = find(storage, {"T", "t", "tvec", "translation"});
  if (rotation) camera.rotation = rotation_of(*rotation);
  if (translation) camera.translation = vector3_of(*translation, "the translation");
}

std::string name_of(const OpenCvStorage& storage) {
  const StorageEntry* entry = find(storage, {"camera_name", "name"});
  std::string name = entry ? entry->text : "";
  for (const char* ending : {".yaml", ".yml", ".xml"}) {
    const std::string tail = ending;
    if (name.size() > tail.size() && name.compare(name.size() - tail.size(), tail.size(), tail) == 0) {
      name.resize(name.size() - tail.size());  // some tools write their file's name here
    }
  }
  return name;
}

void read_single(const InputFile& file, const OpenCvStorage& storage, const StorageEntry& matrix,
                 RawCalibration& raw) {
  RawCamera camera;
  read_lens(matrix,
            find(storage, {"distortion_coefficients", "distCoeffs", "Distortion_Coefficients", "dist_coeffs",
                           "distortion", "D"}),
            camera);
  camera.name = name_of(storage);
  read_size(storage, camera);
  read_pose(storage, camera);
  if (const StorageEntry* rms = find(storage, {"avg_reprojection_error", "Avg_Reprojection_Error"})) {
    camera.rms_px = number_of(*rms, "the reprojection error");
  }
  if (find(storage, {"extrinsic_parameters", "Extrinsic_Parameters"})) {
    raw.notes.push_back(file.path.string() +
                        ": extrinsic_parameters are poses of the board, not of the camera; left out");
  }
  raw.cameras.push_back(std::move(camera));
}

bool read_stereo(const OpenCvStorage& storage, RawCalibration& raw) {
  const std::array matrices{find(storage, {"M1", "cameraMatrix1", "camera_matrix_1", "K1"}),
                            find(storage, {"M2", "cameraMatrix2", "camera_matrix_2", "K2"})};
  const std::array coefficients{find(storage, {"D1", "distCoeffs1", "distortion_coefficients_1"}),
                                find(storage, {"D2", "distCoeffs2", "distortion_coefficients_2"})};
  if (!matrices[0] || !matrices[1]) return false;
  for (std::size_t n = 0; n < 2; ++n) {
    RawCamera camera;
    read_lens(*matrices[n], coefficients[n], camera);
    read_size(storage, camera);
    raw.cameras.push_back(std::move(camera));
  }
  return true;
}

/// The first camera of a pair is its world.
void set_pair_pose(const OpenCvStorage& pose, RawCamera& first, RawCamera& second) {
  read_pose(pose, second);
  if (!second.rotation && !second.translation) return;
  first.rotation = Eigen::Matrix3d::Identity();
  first.translation = Eigen::Vector3d::Zero();
}

}  // namespace

RawCalibration read_opencv_calibration(const std::vector<InputFile>& files) {
  RawCalibration raw;
  raw.format = "OpenCV";
  std::vector<OpenCvStorage> pairs, poses;
  for (const InputFile& file : files) {
    const OpenCvStorage storage = read_opencv_storage(file);
    refuse_other_models(storage);
    if (const StorageEntry* matrix =
            find(storage, {"camera_matrix", "cameraMatrix", "Camera_Matrix", "intrinsics", "K", "M"})) {
      read_single(file, storage, *matrix, raw);
    } else if (read_stereo(storage, raw)) {
      pairs.push_back(storage);
    } else if (find(storage, {"R"}) && find(storage, {"T"})) {
      poses.push_back(storage);
    } else {
      throw Error(file.path.string() +
                  ":1:1: no camera in it: neither camera_matrix nor M1, M2 nor the R, T of a stereo pair");
    }
  }
  const bool one_pair = pairs.size() == 1 && raw.cameras.size() == 2;
  if ((!pairs.empty() && !one_pair) || poses.size() > 1 || (poses.size() == 1 && raw.cameras.size() != 2)) {
    throw Error(
        files.front().path.string() +
        ": a stereo pair (with its R and T) must be imported alone: how it stands to other cameras is "
        "not in the files");
  }
  if (raw.cameras.size() == 2 && (one_pair || poses.size() == 1)) {
    set_pair_pose(poses.empty() ? pairs[0] : poses[0], raw.cameras[0], raw.cameras[1]);
  }
  return raw;
}

}  // namespace glint
