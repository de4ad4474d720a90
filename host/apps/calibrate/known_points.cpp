// SPDX-License-Identifier: MIT
#include "host/apps/calibrate/known_points.hpp"

#include <cstdio>
#include <filesystem>

#include "host/apps/utc_time.hpp"
#include "host/base/error.hpp"
#include "host/calibrate/pnp.hpp"
#include "host/capture/csv_reader.hpp"
#include "host/config/rig.hpp"

namespace glint::apps {
namespace {

constexpr std::size_t kFewestPoints = 4;  // of a plane; target_poses() wants six otherwise
constexpr double kWorst_px = 5.0;         // rms from where on a point was surely measured or typed wrongly

struct CameraPoints {
  std::vector<Eigen::Vector3d> in_world;
  std::vector<Eigen::Vector2d> pixels;
};

std::vector<CameraPoints> read_points(const std::string& file, const Calibration& rig) {
  std::vector<CameraPoints> points(rig.cameras.size());
  CsvReader reader(file);
  while (reader.next()) {
    if (reader.fields() != 6) reader.fail(0, "expected six columns: camera,x_m,y_m,z_m,x_px,y_px");
    if (reader.text(0) == "camera") continue;
    std::size_t camera = 0;
    while (camera < rig.cameras.size() && rig.cameras[camera].name != reader.text(0)) ++camera;
    if (camera == rig.cameras.size()) reader.fail(0, "the rig has no camera of that name");
    points[camera].in_world.emplace_back(reader.real(1, "x_m"), reader.real(2, "y_m"), reader.real(3, "z_m"));
    points[camera].pixels.emplace_back(reader.real(4, "x_px"), reader.real(5, "y_px"));
  }
  return points;
}

}  // namespace

void place_by_known_points(const KnownPoints& a) {
  if (a.rig_file.empty()) throw UsageError("--rig FILE is needed: the cameras' intrinsics");
  const Calibration rig = read_rig(a.rig_file).calibration;
  const std::vector<CameraPoints> points = read_points(a.points, rig);
  Calibration found;
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const std::string& name = rig.cameras[c].name;
    const std::string count = std::to_string(points[c].pixels.size());
    if (points[c].pixels.empty()) {
      std::fprintf(stderr, "glint: note: %s: has no points of %s, which is left out\n", a.points.c_str(),
                   name.c_str());
      continue;
    }
    if (points[c].pixels.size() < kFewestPoints)
      throw Error(a.points + ": has " + count + " points of " + name +
                  "; four on a plane are the least, six or more are better");
    const std::vector<TargetPose> poses = target_poses(rig.cameras[c], points[c].in_world, points[c].pixels);
    if (poses.empty())
      throw Error(a.points + ": no place of " + name + " explains its " + count +
                  " points: six are needed unless all lie in one plane, and no three of four on a line");
    if (poses[0].rms_px > kWorst_px) {
      char text[32];
      std::snprintf(text, sizeof text, "%.1f", poses[0].rms_px);
      throw Error(a.points + ": the points of " + name + " fit no place better than " + text +
                  " px rms: is each pixel beside the right place, in metres, and are the intrinsics those of "
                  "this camera?");
    }
    CameraCalibration camera = rig.cameras[c];
    camera.world_from_camera = poses[0].camera_from_target.inverse();
    camera.rms_px = poses[0].rms_px;
    const Eigen::Vector3d& p = camera.world_from_camera.translation;
    std::printf("%-10s stands at (%.3f, %.3f, %.3f) m; %s points, %.3f px rms\n", name.c_str(), p.x(), p.y(),
                p.z(), count.c_str(), camera.rms_px);
    if (poses.size() > 1 && poses[1].rms_px < 2.0 * poses[0].rms_px) {
      std::fprintf(stderr,
                   "glint: note: %s: a second place explains its points nearly as well (%.3f px rms): points "
                   "at other heights, "
                   "or further apart, would tell\n",
                   name.c_str(), poses[1].rms_px);
    }
    found.cameras.push_back(std::move(camera));
  }
  if (found.cameras.empty()) throw Error(a.points + ": has no points");
  found.made_at = utc_now();
  found.made_from =
      "glint calibrate extrinsics, known points of " + std::filesystem::path(a.points).filename().string();
  write_calibration(a.output, found, a.force);
  std::printf("wrote %s\n", a.output.c_str());
}

}  // namespace glint::apps
