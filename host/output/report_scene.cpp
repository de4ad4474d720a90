// SPDX-License-Identifier: MIT
// Floor grid, axes, camera frusta and trajectories in parallel projection.
#include "host/output/report_scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Core>

#include "host/page/page_text.hpp"

namespace glint {

namespace {

using Eigen::Vector3d;
using Line3 = std::vector<Vector3d>;

/// How the world is seen. The page's script repeats this projection: keep the two alike.
struct View {
  double azimuth_rad = 0, elevation_rad = 0;
  double width = 0, height = 0;  // of the picture, in user units
  double units_per_m = 1;
  Vector3d centre_in_world = Vector3d::Zero();

  Eigen::Vector2d operator()(const Vector3d& point_in_world) const {
    const Vector3d p = point_in_world - centre_in_world;
    const double ca = std::cos(azimuth_rad), sa = std::sin(azimuth_rad);
    const double right = p.x() * ca + p.y() * sa, away = p.y() * ca - p.x() * sa;
    const double up = p.z() * std::cos(elevation_rad) + away * std::sin(elevation_rad);
    return {width / 2 + right * units_per_m, height / 2 - up * units_per_m};
  }
};

/// What the picture must hold, rounded outwards to grid lines.
struct Extent {
  Vector3d low = Vector3d::Zero(), high = Vector3d::Ones();
  double step_m = 1;
};

Extent extent_of(const ReportData& data) {
  std::array<std::vector<double>, 3> values;
  for (const ReportTrajectory& trajectory : data.trajectories) {
    for (const auto& piece : trajectory.pieces_in_world) {
      for (const Vector3d& p : piece) {
        for (int axis = 0; axis < 3; ++axis) values[static_cast<std::size_t>(axis)].push_back(p[axis]);
      }
    }
  }
  Extent extent;
  bool any = false;
  const auto include = [&](const Vector3d& p) {
    extent.low = any ? extent.low.cwiseMin(p).eval() : p;
    extent.high = any ? extent.high.cwiseMax(p).eval() : p;
    any = true;
  };
  if (!values[0].empty()) {
    // A stray point far away must not shrink everything else: half a percent may fall outside.
    Vector3d low, high;
    for (int axis = 0; axis < 3; ++axis) {
      auto& v = values[static_cast<std::size_t>(axis)];
      std::sort(v.begin(), v.end());
      low[axis] = v[static_cast<std::size_t>(0.005 * static_cast<double>(v.size() - 1))];
      high[axis] = v[static_cast<std::size_t>(std::ceil(0.995 * static_cast<double>(v.size() - 1)))];
    }
    include(low);
    include(high);
  }
  for (const CameraCalibration& camera : data.cameras) {
    if (camera.world_from_camera.translation.allFinite()) include(camera.world_from_camera.translation);
  }
  if (!any) include(Vector3d::Zero());
  const double size = std::max((extent.high - extent.low).maxCoeff(), 1e-3);
  extent.step_m = round_step(size, 6);
  // The floor is the ground where the scene stands on it.
  if (extent.low.z() > 0 && extent.low.z() < size) extent.low.z() = 0;
  for (int axis = 0; axis < 3; ++axis) {
    extent.low[axis] = std::floor(extent.low[axis] / extent.step_m + 1e-6) * extent.step_m;
    extent.high[axis] = std::ceil(extent.high[axis] / extent.step_m - 1e-6) * extent.step_m;
    if (extent.high[axis] - extent.low[axis] < extent.step_m / 2)
      extent.high[axis] = extent.low[axis] + extent.step_m;
  }
  return extent;
}

/// Writes one picture. With `turnable`, world coordinates go with every element.
class SceneWriter {
 public:
  SceneWriter(const View& view, double step_m, bool turnable) : view_(view), turnable_(turnable) {
    // Enough decimals for a thousandth of a grid step.
    decimals_ = std::clamp(static_cast<int>(std::ceil(3 - std::log10(step_m))), 0, 9);
  }

  void lines(const std::string& attributes, const std::vector<Line3>& pieces) {
    std::string path, world;
    for (const Line3& piece : pieces) {
      if (piece.empty()) continue;
      if (!world.empty()) world += ';';
      bool first = true;
      for (const Vector3d& p : piece) {
        path.append(first ? "M" : "L").append(screen(p, " "));
        world.append(first ? "" : " ").append(in_world(p));
        first = false;
      }
      if (piece.size() == 1) path += "h0";  // a round cap makes it a dot
    }
    if (!path.empty()) svg_ += "<path " + attributes + data(world) + " d=\"" + path + "\"/>";
  }

  void dot(const std::string& attributes, const Vector3d& p, const std::string& title) {
    const Eigen::Vector2d at = view_(p);
    svg_ += "<circle " + attributes + data(in_world(p)) + " cx=\"" + short_number(at.x(), 1) + "\" cy=\"" +
            short_number(at.y(), 1) + "\" r=\"3.5\"><title>" + escape_html(title) + "</title></circle>";
  }

  /// dx, dy: from the point to the text's anchor, in user units.
  void text(const std::string& attributes, const Vector3d& p, double dx, double dy,
            const std::string& words) {
    const Eigen::Vector2d at = view_(p) + Eigen::Vector2d(dx, dy);
    const std::string shift =
        turnable_ ? " data-o=\"" + short_number(dx, 1) + " " + short_number(dy, 1) + "\"" : "";
    svg_ += "<text " + attributes + data(in_world(p)) + shift + " x=\"" + short_number(at.x(), 1) +
            "\" y=\"" + short_number(at.y(), 1) + "\">" + escape_html(words) + "</text>";
  }

  std::string finish(const std::string& what) const {
    const auto n = [](double v) { return short_number(v, 6); };
    std::string s = "<svg class=\"scene\" viewBox=\"0 0 " + n(view_.width) + " " + n(view_.height) +
                    "\" role=\"img\" aria-label=\"" + what + "\"";
    if (turnable_) {
      s += " id=\"turn\" data-view=\"" + n(view_.azimuth_rad) + " " + n(view_.elevation_rad) + " " +
           n(view_.units_per_m) + " " + n(view_.centre_in_world.x()) + " " + n(view_.centre_in_world.y()) +
           " " + n(view_.centre_in_world.z()) + "\"";
    }
    return s + ">" + svg_ + "</svg>";
  }

 private:
  std::string screen(const Vector3d& p, const char* between) const {
    const Eigen::Vector2d at = view_(p);
    return short_number(at.x(), 1) + between + short_number(at.y(), 1);
  }
  std::string in_world(const Vector3d& p) const {
    if (!turnable_) return {};
    return short_number(p.x(), decimals_) + " " + short_number(p.y(), decimals_) + " " +
           short_number(p.z(), decimals_);
  }
  std::string data(const std::string& world) const { return turnable_ ? " data-p=\"" + world + "\"" : ""; }

  View view_;
  bool turnable_;
  int decimals_ = 3;
  std::string svg_;
};

void write_floor(SceneWriter& scene, const Extent& e, bool with_height) {
  const double z = e.low.z(), step = e.step_m;
  std::vector<Line3> grid;
  for (double x = e.low.x(); x <= e.high.x() + step / 4; x += step) {
    grid.push_back({{x, e.low.y(), z}, {x, e.high.y(), z}});
  }
  for (double y = e.low.y(); y <= e.high.y() + step / 4; y += step) {
    grid.push_back({{e.low.x(), y, z}, {e.high.x(), y, z}});
  }
  scene.lines("class=\"grid\"", grid);
  const Vector3d corner(with_height ? e.high.x() : e.low.x(), e.low.y(), z);
  std::vector<Line3> axes{{{e.low.x(), e.low.y(), z}, {e.high.x(), e.low.y(), z}},
                          {corner, {corner.x(), e.high.y(), z}}};
  if (with_height) axes.push_back({{e.low.x(), e.low.y(), z}, {e.low.x(), e.low.y(), e.high.z()}});
  scene.lines("class=\"axis\"", axes);

  const double y_dx = with_height ? 8 : -8;
  const std::string y_kind = with_height ? "class=\"start\"" : "class=\"end\"";
  for (double x = e.low.x(); x <= e.high.x() + step / 4; x += step) {
    scene.text("class=\"mid\"", {x, e.low.y(), z}, with_height ? -6 : 0, 16, short_number(x, 4));
  }
  for (double y = e.low.y() + (with_height ? step : 0); y <= e.high.y() + step / 4; y += step) {
    scene.text(y_kind, {corner.x(), y, z}, y_dx, with_height ? 12 : 4, short_number(y, 4));
  }
  scene.text("class=\"mid unit\"", {(e.low.x() + e.high.x()) / 2, e.low.y(), z}, with_height ? -22 : 0, 34,
             "x (m)");
  if (!with_height) {
    scene.text("class=\"end unit\"", {e.low.x(), e.high.y(), z}, -8, -14, "y (m)");
    return;
  }
  scene.text("class=\"start unit\"", {corner.x(), (e.low.y() + e.high.y()) / 2, z}, 26, 26, "y (m)");
  for (double height = e.low.z() + step; height <= e.high.z() + step / 4; height += step) {
    scene.text("class=\"end\"", {e.low.x(), e.low.y(), height}, -8, 4, short_number(height, 4));
  }
  scene.text("class=\"end unit\"", {e.low.x(), e.low.y(), (e.low.z() + e.high.z()) / 2}, -36, 4, "z (m)");
}

void write_cameras(SceneWriter& scene, const ReportData& data, double depth_m, const Vector3d& middle,
                   bool from_above) {
  std::size_t camera_number = 0;
  for (const CameraCalibration& camera : data.cameras) {
    ++camera_number;
    const Pose& pose = camera.world_from_camera;
    if (!pose.translation.allFinite() || camera.fx_px == 0.0 || camera.fy_px == 0.0) continue;
    const auto corner = [&](double x_px, double y_px) -> Vector3d {
      return pose *
             (Vector3d((x_px - camera.cx_px) / camera.fx_px, (y_px - camera.cy_px) / camera.fy_px, 1.0) *
              depth_m);
    };
    const double right = std::max(camera.width_px, 1u) - 0.5, bottom = std::max(camera.height_px, 1u) - 0.5;
    const std::array<Vector3d, 4> c{corner(-0.5, -0.5), corner(right, -0.5), corner(right, bottom),
                                    corner(-0.5, bottom)};
    const Vector3d& eye = pose.translation;
    scene.lines("class=\"lens\"", {{c[0], c[1], c[2], c[3], c[0]}});
    scene.lines("class=\"camera\"", {{eye, c[0]}, {eye, c[1]}, {eye, c[2]}, {eye, c[3]}});
    const std::string name = camera.name.empty() ? "camera " + std::to_string(camera_number) : camera.name;
    if (from_above) {  // outwards, but not into the axis on the left
      scene.text("class=\"mid name\"", eye, 0, eye.y() > middle.y() ? -9 : 19, name);
      continue;
    }
    const bool left = eye.x() < middle.x();
    scene.text(left ? "class=\"end name\"" : "class=\"start name\"", eye, left ? -9 : 9, -7, name);
  }
}

void write_trajectories(SceneWriter& scene, const ReportData& data) {
  std::size_t position = 0;
  for (const ReportTrajectory& trajectory : data.trajectories) {
    const std::string colour = track_colour(position++);
    if (trajectory.pieces_in_world.empty() || trajectory.pieces_in_world.back().empty()) continue;
    scene.lines("class=\"track\" style=\"stroke:" + colour + "\"", trajectory.pieces_in_world);
    scene.dot("class=\"now\" style=\"fill:" + colour + "\"", trajectory.pieces_in_world.back().back(),
              "track " + std::to_string(number(trajectory.id)));
  }
}

std::string scene_svg(const ReportData& data, const Extent& extent, const View& view, bool turnable,
                      const std::string& what) {
  SceneWriter scene(view, extent.step_m, turnable);
  write_floor(scene, extent, turnable);
  write_trajectories(scene, data);
  write_cameras(scene, data, 0.09 * (extent.high - extent.low).maxCoeff(), view.centre_in_world, !turnable);
  return scene.finish(what);
}

}  // namespace

std::string track_colour(std::size_t position) {
  // Steps of the golden angle keep neighbours apart for any number of tracks; two shades double that.
  const double hue = std::fmod(205.0 + 137.508 * static_cast<double>(position), 360.0);
  return "hsl(" + short_number(hue, 0) + (position % 2 == 0 ? " 68% 50%)" : " 58% 58%)");
}

std::string oblique_scene_svg(const ReportData& data) {
  const Extent extent = extent_of(data);
  View view;
  view.azimuth_rad = 35.0 * std::numbers::pi / 180.0;
  view.elevation_rad = 28.0 * std::numbers::pi / 180.0;
  view.width = 760;
  view.height = 520;
  view.centre_in_world = (extent.low + extent.high) / 2;
  const Vector3d half = (extent.high - extent.low) / 2;
  // Any azimuth fits; so does the elevation that it starts with.
  const double radius = std::hypot(half.x(), half.y());
  const double tall = radius * std::sin(view.elevation_rad) + half.z() * std::cos(view.elevation_rad);
  view.units_per_m = std::min((view.width / 2 - 60) / radius, (view.height / 2 - 40) / tall);
  return scene_svg(data, extent, view, true, "cameras and trajectories, seen from the side");
}

std::string top_scene_svg(const ReportData& data) {
  const Extent extent = extent_of(data);
  View view;
  view.elevation_rad = std::numbers::pi / 2;
  view.width = 520;
  view.height = 520;
  view.centre_in_world = (extent.low + extent.high) / 2;
  const Vector3d half = (extent.high - extent.low) / 2;
  view.units_per_m = std::min((view.width / 2 - 62) / half.x(), (view.height / 2 - 50) / half.y());
  return scene_svg(data, extent, view, false, "cameras and trajectories, seen from above");
}

}  // namespace glint
