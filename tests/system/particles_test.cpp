// SPDX-License-Identifier: MIT
// Real images to 3D: the particles recording, against what another tool found in it.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <iostream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/temp_dir.hpp"
#include "tests/support/test_data.hpp"
#include "tests/system/run_glint.hpp"

namespace glint::test {
namespace {

namespace fs = std::filesystem;

/// Rows of numbers, separated by commas or blanks; lines that do not begin with a number are passed over.
std::vector<std::vector<double>> read_table(const fs::path& path) {
  std::ifstream file(path);
  std::vector<std::vector<double>> rows;
  for (std::string line; std::getline(file, line);) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream words(line);
    std::vector<double> row;
    for (double value = 0.0; words >> value;) row.push_back(value);
    if (!row.empty()) rows.push_back(row);
  }
  return rows;
}

double median(std::vector<double> values) {
  if (values.empty()) return 1e9;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

using Position = std::array<double, 3>;

/// X Y Z (mm), its blob's number in each camera's list of that frame, error, frame.
struct PeerParticle {
  Position position_mm;
  std::array<std::size_t, 3> blob;
  int frame;
};

class Particles : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto found = test_data("particles-3cam");
    if (!found) GTEST_SKIP();
    data_ = *found;
    std::uintmax_t bytes = 0;
    for (const auto& entry : fs::recursive_directory_iterator(data_)) {
      if (entry.path().extension() == ".tif") bytes += entry.file_size();
    }
    if (bytes != 15'747'312) {
      std::cout << "SKIPPED: the images in " << data_ << " are not the original ones (" << bytes
                << " bytes)\n";
      GTEST_SKIP();
    }
    for (const std::vector<double>& r : read_table(data_ / "peer_particles.txt")) {
      particles_.push_back(
          {{r[0], r[1], r[2]},
           {static_cast<std::size_t>(r[3]), static_cast<std::size_t>(r[4]), static_cast<std::size_t>(r[5])},
           static_cast<int>(r[7])});
    }
    ASSERT_EQ(particles_.size(), 158u);
    calibration_ = (scratch_.path() / "calibration.toml").string();
    ASSERT_EQ(
        run_glint({"import", "calibration", (data_ / "calibration.json").string(), "--output", calibration_})
            .exit_code,
        0);
  }

  fs::path data_;
  std::vector<PeerParticle> particles_;
  TempDir scratch_;
  std::string calibration_;
};

TEST_F(Particles, BlobsOfThePeerAreFound) {
  const std::string csv = (scratch_.path() / "blobs.csv").string();
  const Outcome o =
      run_glint({"detect", "images:" + data_.string(), "--rig", calibration_, "--background", "4",
                 "--threshold", "4", "--min-area", "2", "--output", "csv:" + csv, "--quiet"});
  ASSERT_EQ(o.exit_code, 0) << o.err;
  std::map<std::pair<int, int>, std::vector<std::array<double, 2>>> blobs;  // by camera and frame, from 0
  for (const std::vector<double>& r : read_table(csv)) {
    blobs[{static_cast<int>(r[1]) - 1, static_cast<int>(r[0]) - 1}].push_back({r[2], r[3]});
  }
  constexpr std::array<int, 3> kWanted{155, 151, 155};
  for (int camera = 0; camera < 3; ++camera) {
    std::map<int, std::vector<std::array<double, 2>>> peer;
    for (const std::vector<double>& r :
         read_table(data_ / ("peer_blobs_cam" + std::to_string(camera + 1) + ".txt"))) {
      peer[static_cast<int>(r[5])].push_back({r[1], r[0]});
    }
    std::vector<double> distances;
    for (const PeerParticle& p : particles_) {
      const std::array<double, 2> at = peer[p.frame].at(p.blob[static_cast<std::size_t>(camera)]);
      double nearest = 1e9;
      for (const auto& blob : blobs[{camera, p.frame}])
        nearest = std::min(nearest, std::hypot(blob[0] - at[0], blob[1] - at[1]));
      if (nearest < 1.5) distances.push_back(nearest);
    }
    std::cout << "camera " << camera + 1 << ": " << distances.size() << " of 158, median "
              << median(distances) << " px\n";
    EXPECT_GE(static_cast<int>(distances.size()), kWanted[static_cast<std::size_t>(camera)]);
    EXPECT_LE(median(distances), 0.1);
  }
}

double distance(const Position& a, const Position& b) {
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
}

/// By how much the steps between four places differ at most.
double unsteadiness_mm(const std::array<Position, 4>& at) {
  double worst = 0.0;
  for (std::size_t k = 0; k < 2; ++k) {
    const Position middle{0.5 * (at[k][0] + at[k + 2][0]), 0.5 * (at[k][1] + at[k + 2][1]),
                          0.5 * (at[k][2] + at[k + 2][2])};
    worst = std::max(worst, 2.0 * distance(at[k + 1], middle));
  }
  return worst;
}

TEST_F(Particles, ParticlesOfThePeerAreFoundIn3DAndMoreThroughAllFrames) {
  // Particles drift by about half a millimetre from frame to frame.
  const std::string rig =
      scratch_
          .write("rig.toml",
                 "format = 1\nkind = \"rig\"\n[rig]\nname = \"particles\"\nrate_hz = 50.0\n"
                 "calibration = \"calibration.toml\"\n[detect]\nthreshold = 7\nbackground_frames = 4\n"
                 "min_area_px = 2\n[match]\nsigma_px = 0.4\ngate_px = 2.0\nmin_range_m = 0.48\n"
                 "max_range_m = 0.66\n[track]\nmax_speed_m_s = 0.1\nacceleration_sd_m_s2 = 2.0\n")
          .string();
  const std::string csv = (scratch_.path() / "points.csv").string();
  const Outcome o =
      run_glint({"track", "images:" + data_.string(), "--rig", rig, "--output", "csv:" + csv, "--quiet"});
  ASSERT_EQ(o.exit_code, 0) << o.err;
  std::map<int, std::map<int, Position>> tracks;  // by id, then by frame from 0
  for (const std::vector<double>& r : read_table(csv)) {
    tracks[static_cast<int>(r[2])][static_cast<int>(r[0]) - 1] = {r[3] * 1e3, r[4] * 1e3, r[5] * 1e3};
  }
  std::vector<double> distances;
  std::set<int> of_the_peer;
  for (const PeerParticle& p : particles_) {
    double nearest = 0.5;
    int found = 0;
    for (const auto& [id, track] : tracks) {
      const auto at = track.find(p.frame);
      if (at == track.end() || distance(at->second, p.position_mm) >= nearest) continue;
      nearest = distance(at->second, p.position_mm);
      found = id;
    }
    if (found == 0) continue;
    distances.push_back(nearest);
    of_the_peer.insert(found);
  }
  int whole = 0, further = 0, steady = 0;
  for (const auto& [id, track] : tracks) {
    if (track.size() != 4) continue;
    ++whole;
    if (of_the_peer.contains(id)) continue;
    ++further;
    if (unsteadiness_mm({track.at(0), track.at(1), track.at(2), track.at(3)}) < 0.5) ++steady;
  }
  std::cout << distances.size() << " of 158 particles within 0.5 mm, median " << median(distances) << " mm; "
            << whole << " tracks of all 4 frames, " << further << " of them further ones, of which " << steady
            << " go on steadily within 0.5 mm\n";
  EXPECT_GE(distances.size(), 150u);
  EXPECT_LE(median(distances), 0.15);
  EXPECT_GE(whole, 120);
  EXPECT_GE(steady, 60);
}

}  // namespace
}  // namespace glint::test
