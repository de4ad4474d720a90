// SPDX-License-Identifier: MIT
// Rectangles through the lens.
#include "host/sim/board_view.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/base/check.hpp"
#include "host/sim/backdrop.hpp"
#include "host/sim/blur.hpp"
#include "host/sim/random.hpp"
#include "host/sim/sim_camera.hpp"

namespace glint::sim {
namespace {

constexpr double kStep_px = 0.25;  // along outlines; halving it changes no pixel by a hundredth of a level

std::array<Eigen::Vector2d, 4> corners_of(const Eigen::AlignedBox2d& box) {
  return {box.min(), {box.max().x(), box.min().y()}, box.max(), {box.min().x(), box.max().y()}};
}

/// The camera alone, at the origin.
SimCamera at_origin(const CameraCalibration& calibration) {
  CameraCalibration camera = calibration;
  camera.world_from_camera = Pose{};
  return SimCamera(camera);
}

void trace(const SimCamera& camera, const Pose& camera_from_board, const Eigen::AlignedBox2d& box,
           std::vector<OutlinePoint>& outline) {
  outline.clear();
  const auto corners = corners_of(box);
  const Eigen::Matrix3d rotation = camera_from_board.rotation.toRotationMatrix();
  const auto in_camera = [&](const Eigen::Vector2d& p) -> Eigen::Vector3d {
    return rotation.leftCols<2>() * p + camera_from_board.translation;
  };
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d from = corners[i], edge = corners[(i + 1) % 4] - from;
    const double length_px =
        (camera.project(in_camera(from + edge)) - camera.project(in_camera(from))).norm();
    const int steps = std::max(2, static_cast<int>(std::ceil(length_px / kStep_px)));
    const Eigen::Vector3d step = rotation.leftCols<2>() * edge / steps;
    for (int n = 0; n < steps; ++n) {  // midpoints: the rule's error goes with the square of the step
      Eigen::Matrix<double, 2, 3> by_camera;
      const Eigen::Vector2d pixel = camera.project(in_camera(from + (n + 0.5) / steps * edge), &by_camera);
      const Eigen::Vector2d moved = by_camera * step;
      outline.push_back({pixel.x(), pixel.y(), moved.x(), moved.y()});
    }
  }
}

}  // namespace

std::vector<float> board_image(const CameraCalibration& calibration, const Pose& camera_from_board,
                               const PrintedBoard& board, const SimSensor& sensor, const BoardLight& light) {
  const SimCamera camera = at_origin(calibration);
  const std::size_t width = calibration.width_px, height = calibration.height_px;
  std::vector<float> image(width * height, static_cast<float>(sensor.black_level_grey + light.room_grey));
  const BlurKernel kernel(sensor.psf_sigma_px);
  std::vector<OutlinePoint> outline;
  Patch patch;
  const auto add = [&](const Eigen::AlignedBox2d& box, double grey) {
    trace(camera, camera_from_board, box, outline);
    Eigen::AlignedBox2d bounds;
    for (const OutlinePoint& p : outline) bounds.extend(Eigen::Vector2d(p.x_px, p.y_px));
    const double reach = kernel.reach() + 1.0;
    const auto clipped = [](double value, double most) {
      return static_cast<int>(std::clamp(value, 0.0, most));
    };
    const double last_x = static_cast<double>(width) - 1.0, last_y = static_cast<double>(height) - 1.0;
    if (bounds.max().x() + reach < 0.0 || bounds.max().y() + reach < 0.0 ||
        bounds.min().x() - reach > last_x || bounds.min().y() - reach > last_y)
      return;
    patch.reset(clipped(std::floor(bounds.min().x() - reach), last_x),
                clipped(std::floor(bounds.min().y() - reach), last_y),
                clipped(std::ceil(bounds.max().x() + reach), last_x),
                clipped(std::ceil(bounds.max().y() + reach), last_y), false);
    patch.add_filled(kernel, outline, moments(outline).orientation, grey);
    for (int y = 0; y < patch.height_px(); ++y) {
      float* row = image.data() + static_cast<std::size_t>(patch.y_min_px() + y) * width + patch.x_min_px();
      for (int x = 0; x < patch.width_px(); ++x) row[x] += patch.row(y)[x];
    }
  };
  add(board.sheet, light.white_grey - light.room_grey);
  for (const Eigen::AlignedBox2d& box : board.black) add(box, light.black_grey - light.white_grey);
  return image;
}

void board_picture(const CameraCalibration& calibration, const Pose& camera_from_board,
                   const PrintedBoard& board, const SimSensor& sensor, std::uint64_t seed,
                   std::uint8_t* pixels, std::uint32_t stride_bytes, const BoardLight& light) {
  const std::vector<float> image = board_image(calibration, camera_from_board, board, sensor, light);
  SimOptions options;
  options.sensor = sensor;
  const NoiseModel noise(options);
  const NormalTable normal;
  Random random(stream_seed(seed, Stream::BoardNoise));
  for (std::uint32_t y = 0; y < calibration.height_px; ++y) {
    for (std::uint32_t x = 0; x < calibration.width_px; ++x) {
      const float mean = image[std::size_t{y} * calibration.width_px + x];
      pixels[std::size_t{y} * stride_bytes + x] =
          to_pixel(mean + std::sqrt(noise.variance_grey2(mean)) * normal.draw(random));
    }
  }
}

bool board_in_view(const CameraCalibration& calibration, const Pose& camera_from_board,
                   const Eigen::AlignedBox2d& area, double margin_px) {
  const SimCamera camera = at_origin(calibration);
  const Eigen::Vector3d normal =
      camera_from_board.rotation * Eigen::Vector3d::UnitZ();  // away from its viewer
  for (const Eigen::Vector2d& corner : corners_of(area)) {
    const Eigen::Vector3d point = camera_from_board * Eigen::Vector3d(corner.x(), corner.y(), 0.0);
    if (!camera.images(point, 0.0) || normal.dot(point) <= 0.0) return false;
    const Eigen::Vector2d pixel = camera.project(point);
    if (pixel.x() < margin_px || pixel.y() < margin_px ||
        pixel.x() > calibration.width_px - 1.0 - margin_px ||
        pixel.y() > calibration.height_px - 1.0 - margin_px)
      return false;
  }
  return true;
}

}  // namespace glint::sim
