// SPDX-License-Identifier: MIT
// Imported calibrations against real recordings: the points that go with them must agree, which decides
// directions, units and pixel conventions. Needs the shared recordings (GLINT_TEST_DATA).
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>

#include "host/config/import_calibration.hpp"
#include "host/config/rig.hpp"
#include "tests/unit/config/config_fixture.hpp"

namespace glint {
namespace {

using std::filesystem::path;

class ImportRecordings : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* folder = std::getenv("GLINT_TEST_DATA");
    if (!folder || !std::filesystem::is_directory(folder)) {
      GTEST_SKIP() << "SKIPPED: GLINT_TEST_DATA does not name the folder of recordings";
    }
    data_ = std::filesystem::absolute(folder);
  }

  /// Imports, and checks that writing and reading the result loses nothing.
  Calibration import(const std::vector<path>& files, const ImportOptions& options = {}) {
    std::vector<path> paths;
    for (const path& file : files) paths.push_back(data_ / file);
    Calibration calibration = import_calibration(paths, options);
    const test::TempFolder folder;
    write_calibration(folder / "c.toml", calibration);
    test::expect_same(read_calibration(folder / "c.toml"), calibration);
    return calibration;
  }

  /// Rows of numbers; fields that are none become nan.
  std::vector<std::vector<double>> rows(const path& file, char separator, bool header = false) {
    std::ifstream in(data_ / file);
    EXPECT_TRUE(in) << file;
    std::vector<std::vector<double>> result;
    std::string line;
    if (header) std::getline(in, line);
    while (std::getline(in, line)) {
      std::istringstream fields(line);
      std::vector<double> row;
      for (std::string field; std::getline(fields, field, separator);) {
        double value = std::nan("");
        std::from_chars(field.data(), field.data() + field.size(), value);
        row.push_back(value);
      }
      result.push_back(row);
    }
    return result;
  }

  path data_;
};

struct View {
  const Camera* camera;
  Eigen::Vector2d pixel;
};

/// Linear triangulation in the z = 1 planes (Hartley and Zisserman, Multiple View Geometry, 12.2,
/// homogeneous); nothing if a pixel cannot be undistorted.
std::optional<Eigen::Vector3d> linear_point(const std::vector<View>& views) {
  Eigen::MatrixXd a(2 * static_cast<Eigen::Index>(views.size()), 4);
  Eigen::Index row = 0;
  for (const View& view : views) {
    const auto normalized = view.camera->undistort(view.pixel);
    if (!normalized) return std::nullopt;
    const Pose camera_from_world = view.camera->calibration().world_from_camera.inverse();
    Eigen::Matrix<double, 3, 4> p;
    p << camera_from_world.rotation.toRotationMatrix(), camera_from_world.translation;
    a.row(row++) = normalized->x() * p.row(2) - p.row(0);
    a.row(row++) = normalized->y() * p.row(2) - p.row(1);
  }
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(a, Eigen::ComputeFullV);
  return svd.matrixV().col(3).hnormalized();
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<Camera> cameras_of(const Calibration& calibration) {
  return {calibration.cameras.begin(), calibration.cameras.end()};
}

double distance(const Calibration& c, std::size_t a, std::size_t b) {
  return (c.cameras[a].world_from_camera.translation - c.cameras[b].world_from_camera.translation).norm();
}

TEST_F(ImportRecordings, WandCamerasStandWhereTheyWereMeasured) {
  ImportOptions options;
  options.metres_per_unit = 0.001;
  options.names = {"frame_1", "frame_2", "frame_3"};
  const Calibration c = import({"ewand-3cam-led-wand/frame_1.yaml", "ewand-3cam-led-wand/frame_2.yaml",
                                "ewand-3cam-led-wand/frame_3.yaml"},
                               options);
  // The file's own solution against a later bundle adjustment: 0.3 to 0.5 %. Read as world_from_camera they
  // would be 12, 5 and 46 % off.
  EXPECT_NEAR(distance(c, 0, 1), 4.9570, 0.006 * 4.9570);
  EXPECT_NEAR(distance(c, 0, 2), 5.8915, 0.006 * 5.8915);
  EXPECT_NEAR(distance(c, 1, 2), 3.1959, 0.006 * 3.1959);

  const std::vector<Camera> cameras = cameras_of(c);
  std::vector<std::vector<std::vector<double>>> points;
  for (int n = 1; n <= 3; ++n) {
    points.push_back(rows("ewand-3cam-led-wand/frame_" + std::to_string(n) + ".csv", ';'));
  }
  std::vector<double> lengths, errors;
  for (std::size_t row = 0; row < points[0].size(); ++row) {
    std::vector<Eigen::Vector3d> leds;
    for (std::size_t led = 0; led < 3; ++led) {
      std::vector<View> views;
      for (std::size_t n = 0; n < 3; ++n) {
        const double x = points[n][row][1 + 2 * led], y = points[n][row][2 + 2 * led];
        if (x >= 0.0) views.push_back({&cameras[n], {x, y}});
      }
      const auto led_in_world = views.size() == 3 ? linear_point(views) : std::nullopt;
      if (!led_in_world) continue;
      leds.push_back(*led_in_world);
      for (const View& view : views) {
        const auto pixel = view.camera->project(*led_in_world);
        ASSERT_TRUE(pixel) << "the wand is behind a camera";
        errors.push_back((*pixel - view.pixel).norm());
      }
    }
    if (leds.size() == 3) lengths.push_back((leds[0] - leds[2]).norm());
  }
  ASSERT_GT(lengths.size(), 300u);
  std::printf("wand: length %.4f m (true 0.390), reprojection median %.3f px, %zu rows\n", median(lengths),
              median(errors), lengths.size());
  EXPECT_NEAR(median(lengths), 0.390, 0.004);
  EXPECT_LT(median(errors), 2.5);  // the file's poses are not bundle-adjusted
}

TEST_F(ImportRecordings, CaliscopeCornersReproject) {
  const path session = "caliscope-4cam-charuco-video/post_optimization";
  const Calibration c = import({session / "camera_array.toml"});
  const std::vector<Camera> cameras = cameras_of(c);
  ASSERT_EQ(cameras.size(), 4u);
  EXPECT_EQ(c.cameras[2].name, "cam_2");
  std::map<std::tuple<int, int, int>, Eigen::Vector3d> corners;
  const auto key = [](double sync, double object, double corner) {
    return std::tuple(static_cast<int>(sync), static_cast<int>(object), static_cast<int>(corner));
  };
  for (const auto& row : rows(session / "calibration/extrinsic/CHARUCO/xyz_CHARUCO.csv", ',', true)) {
    corners[key(row[0], row[1], row[2])] = {row[3], row[4], row[5]};
  }
  std::map<std::tuple<int, int, int>, std::vector<View>> seen;
  for (const auto& row : rows(session / "calibration/extrinsic/CHARUCO/xy_CHARUCO.csv", ',', true)) {
    const auto corner = key(row[0], row[2], row[3]);
    if (!corners.count(corner)) continue;
    seen[corner].push_back({&cameras.at(static_cast<std::size_t>(row[1])), {row[4], row[5]}});
  }
  EXPECT_EQ(seen.size(), 660u);
  double stored_sum = 0.0;
  std::array<double, 4> sums{}, counts{};
  std::vector<double> distances_mm;
  for (const auto& [corner, views] : seen) {
    const auto point = linear_point(views);
    ASSERT_TRUE(point);
    distances_mm.push_back((*point - corners[corner]).norm() * 1000.0);
    for (const View& view : views) {
      const auto camera = static_cast<std::size_t>(view.camera - cameras.data());
      sums[camera] += (view.camera->project(*point).value() - view.pixel).squaredNorm();
      counts[camera] += 1.0;
      stored_sum += (view.camera->project(corners[corner]).value() - view.pixel).squaredNorm();
    }
  }
  const double count = counts[0] + counts[1] + counts[2] + counts[3];
  EXPECT_EQ(count, 2175.0);
  const double rms = std::sqrt((sums[0] + sums[1] + sums[2] + sums[3]) / count);
  std::printf("caliscope: reprojection rms %.4f px (stored points: %.4f px), median distance %.3f mm\n", rms,
              std::sqrt(stored_sum / count), median(distances_mm));
  EXPECT_NEAR(rms, 1.638, 0.002);
  EXPECT_LT(std::sqrt(stored_sum / count), 1.67);
  EXPECT_NEAR(median(distances_mm), 0.874, 0.01);
  const std::array<double, 4> expected{1.44, 2.17, 1.57, 1.11};
  for (std::size_t n = 0; n < 4; ++n) EXPECT_NEAR(std::sqrt(sums[n] / counts[n]), expected[n], 0.006) << n;
}

TEST_F(ImportRecordings, BothOfCaliscopesFilesSayTheSame) {
  const path session = "caliscope-4cam-charuco-video/post_optimization";
  const Calibration a = import({session / "camera_array.toml"});
  Calibration b = import({session / "config.toml"});
  b.made_from = a.made_from;
  test::expect_same(a, b);
}

TEST_F(ImportRecordings, ParticlesTriangulateWhereThePeerFoundThem) {
  const path folder = "particles-3cam";
  const Calibration c = import({folder / "calibration.json"});
  const std::vector<Camera> cameras = cameras_of(c);
  ASSERT_EQ(cameras.size(), 3u);
  // Blobs by camera, frame and number within the frame. Columns: row col ysize xsize mass frame.
  std::array<std::map<int, std::vector<Eigen::Vector2d>>, 3> blobs;
  for (std::size_t n = 0; n < 3; ++n) {
    for (const auto& row : rows(folder / ("peer_blobs_cam" + std::to_string(n + 1) + ".txt"), '\t')) {
      blobs[n][static_cast<int>(row[5])].emplace_back(row[1], row[0]);
    }
  }
  std::vector<double> distances_mm;
  for (const auto& row : rows(folder / "peer_particles.txt", '\t')) {
    std::vector<View> views;
    for (std::size_t n = 0; n < 3; ++n) {
      const auto& frame = blobs[n][static_cast<int>(row[7])];
      if (row[3 + n] >= 0.0) views.push_back({&cameras[n], frame.at(static_cast<std::size_t>(row[3 + n]))});
    }
    const auto point = linear_point(views);
    ASSERT_TRUE(point);
    distances_mm.push_back((*point * 1000.0 - Eigen::Vector3d(row[0], row[1], row[2])).norm());
  }
  ASSERT_EQ(distances_mm.size(), 158u);
  std::printf("particles: median distance from the peer's %.3f mm\n", median(distances_mm));
  EXPECT_NEAR(median(distances_mm), 0.114, 0.002);
  const auto near = std::count_if(distances_mm.begin(), distances_mm.end(), [](double d) { return d < 0.3; });
  EXPECT_GE(near, 0.94 * 158);
}

TEST_F(ImportRecordings, OpenLptPointsReproject) {
  const path folder = "openlpt-4cam-stereomatch";
  const Calibration c =
      import({folder / "cam1.txt", folder / "cam2.txt", folder / "cam3.txt", folder / "cam4.txt"});
  EXPECT_EQ(c.cameras[3].name, "cam4");
  EXPECT_LT(c.cameras[0].fy_px, 0.0);
  const auto points = rows(folder / "pt3d_list.csv", ',');
  double largest = 0.0;
  for (std::size_t n = 0; n < 4; ++n) {
    const Camera camera(c.cameras[n]);
    const auto pixels = rows(folder / ("pt2d_list_cam" + std::to_string(n + 1) + ".csv"), ',');
    ASSERT_EQ(pixels.size(), points.size());
    for (std::size_t p = 0; p < points.size(); p += 16) {
      const auto pixel = camera.project(Eigen::Vector3d(points[p][0], points[p][1], points[p][2]) / 1000.0);
      ASSERT_TRUE(pixel);
      largest = std::max(largest, (*pixel - Eigen::Vector2d(pixels[p][0], pixels[p][1])).norm());
    }
  }
  std::printf("OpenLPT: largest reprojection error %.1e px\n", largest);
  EXPECT_LT(largest, 0.0005);
}

TEST_F(ImportRecordings, ChessboardIntrinsics) {
  const Calibration left = import({"opencv-stereo-chessboard/left_intrinsics.yml"});
  ASSERT_EQ(left.cameras.size(), 1u);
  EXPECT_EQ(left.cameras[0].name, "left_intrinsics");
  EXPECT_EQ(left.cameras[0].fx_px, 535.91573396163199);
  EXPECT_EQ(left.cameras[0].k1_k2_p1_p2_k3[4], 0.23839153080878486);
  EXPECT_EQ(left.cameras[0].rms_px, 0.39259098975581364);
  ImportOptions options;
  options.width_px = 640;
  options.height_px = 480;
  const Calibration pair = import({"opencv-stereo-chessboard/intrinsics.yml"}, options);
  ASSERT_EQ(pair.cameras.size(), 2u);
  EXPECT_EQ(pair.cameras[1].cx_px, 334.55744527912015);
  EXPECT_EQ(pair.cameras[1].k1_k2_p1_p2_k3[0], -0.16916358306948096);
}

}  // namespace
}  // namespace glint
