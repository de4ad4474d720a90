// SPDX-License-Identifier: MIT
// What the tests of host/config share: a folder that disappears, the text of an error, the shared recordings.
#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <bit>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "host/base/error.hpp"
#include "host/geometry/camera.hpp"

namespace glint::test {

/// A fresh folder, removed with the object.
class TempFolder {
 public:
  TempFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "glint-config-XXXXXX").string();
    if (!::mkdtemp(pattern.data())) throw std::runtime_error("no temporary folder");
    path_ = pattern;
  }
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;
  ~TempFolder() { std::filesystem::remove_all(path_); }

  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  std::filesystem::path write(const std::string& name, const std::string& text) const {
    std::filesystem::remove(path_ / name);  // overwriting would make some file systems wait for the disk
    std::ofstream(path_ / name, std::ios::binary) << text;
    return path_ / name;
  }
  /// `text` without the folder's name, so that expected messages can be written down.
  std::string strip(std::string text) const {
    const std::string prefix = path_.string() + "/";
    for (auto at = text.find(prefix); at != std::string::npos; at = text.find(prefix)) {
      text.erase(at, prefix.size());
    }
    return text;
  }

 private:
  std::filesystem::path path_;
};

inline std::string read_file(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

/// The message that `action` throws; "no error" if it does not.
template <typename Action>
std::string error_of(const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

/// Equal to the last bit: tells 0.0 from -0.0.
inline bool same_bits(double a, double b) {
  return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}

inline void expect_same(const Calibration& a, const Calibration& b) {
  EXPECT_EQ(a.made_at, b.made_at);
  EXPECT_EQ(a.made_from, b.made_from);
  ASSERT_EQ(a.cameras.size(), b.cameras.size());
  for (std::size_t n = 0; n < a.cameras.size(); ++n) {
    SCOPED_TRACE("camera " + std::to_string(n + 1));
    const CameraCalibration &p = a.cameras[n], &q = b.cameras[n];
    EXPECT_EQ(p.name, q.name);
    EXPECT_EQ(p.width_px, q.width_px);
    EXPECT_EQ(p.height_px, q.height_px);
    EXPECT_TRUE(same_bits(p.fx_px, q.fx_px) && same_bits(p.fy_px, q.fy_px));
    EXPECT_TRUE(same_bits(p.cx_px, q.cx_px) && same_bits(p.cy_px, q.cy_px));
    for (std::size_t k = 0; k < 5; ++k) EXPECT_TRUE(same_bits(p.k1_k2_p1_p2_k3[k], q.k1_k2_p1_p2_k3[k]));
    for (int k = 0; k < 3; ++k) {
      EXPECT_TRUE(same_bits(p.world_from_camera.translation[k], q.world_from_camera.translation[k]));
    }
    for (int k = 0; k < 4; ++k) {
      EXPECT_TRUE(
          same_bits(p.world_from_camera.rotation.coeffs()[k], q.world_from_camera.rotation.coeffs()[k]));
    }
    EXPECT_TRUE(same_bits(p.rms_px, q.rms_px));
    EXPECT_EQ(p.intrinsics_sd, q.intrinsics_sd);
  }
}

}  // namespace glint::test
