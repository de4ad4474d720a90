// SPDX-License-Identifier: MIT
// Which bodies can be tracked.
#include "host/body/body_model.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <Eigen/Eigenvalues>

#include "host/base/error.hpp"

namespace glint {
namespace {

constexpr double kLargestSd_m = 0.02;
// Markers nearer than this to a line (root mean square) leave the turn about it undetermined in practice.
constexpr double kLeastWidth_m = 0.004;

std::string in_mm(double metres) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f mm", 1e3 * metres);
  return text;
}

double width_off_a_line_m(std::span<const Eigen::Vector3d> points) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) mean += p / static_cast<double>(points.size());
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : points)
    spread += (p - mean) * (p - mean).transpose() / static_cast<double>(points.size());
  const Eigen::Vector3d squares = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvalues();
  return std::sqrt(std::max(0.0, squares[0] + squares[1]));
}

}  // namespace

void BodyModel::check(std::vector<std::string>& problems) const {
  const std::size_t n = markers_in_body.size();
  if (name.empty()) problems.emplace_back("body.name must not be empty");
  if (!(marker_sd_m > 0.0 && marker_sd_m <= kLargestSd_m))
    problems.emplace_back("body.marker_sd_m must be > 0 and at most " + in_mm(kLargestSd_m) +
                          "; it is in metres");
  if (n < 3 || n > kBodyMarkers) {
    problems.emplace_back("body.markers_in_body_m must hold 3 to " + std::to_string(kBodyMarkers) +
                          " markers, not " + std::to_string(n));
    return;
  }
  if (std::any_of(markers_in_body.begin(), markers_in_body.end(),
                  [](const Eigen::Vector3d& p) { return !p.allFinite(); })) {
    problems.emplace_back("body.markers_in_body_m must be finite numbers");
    return;
  }
  if (diameter_m() > kLargestBody_m)
    problems.emplace_back("body.markers_in_body_m is " + in_mm(diameter_m()) +
                          " across; it is in metres, and bodies are at most " + in_mm(kLargestBody_m));
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) {
      const double gap_m = (markers_in_body[i] - markers_in_body[j]).norm();
      if (gap_m < kLeastMarkerGap_m)
        problems.emplace_back("body.markers_in_body_m has markers " + std::to_string(i + 1) + " and " +
                              std::to_string(j + 1) + " only " + in_mm(gap_m) + " apart; put them at least " +
                              in_mm(kLeastMarkerGap_m) + " apart");
    }
  if (width_off_a_line_m(markers_in_body) < kLeastWidth_m)
    problems.emplace_back(
        "body.markers_in_body_m lies on a line, about which nobody sees it turn; put a marker aside");
}

double BodyModel::diameter_m() const noexcept {
  double largest = 0.0;
  for (const Eigen::Vector3d& a : markers_in_body)
    for (const Eigen::Vector3d& b : markers_in_body) largest = std::max(largest, (a - b).norm());
  return largest;
}

void check_bodies(std::span<const BodyModel> models) {
  std::string text;
  const auto add = [&](std::size_t body, const std::string& problem) {
    if (!text.empty()) text += "\n";
    text += "body " + std::to_string(body + 1) + " (\"" + models[body].name + "\"): " + problem;
  };
  for (std::size_t k = 0; k < models.size(); ++k) {
    std::vector<std::string> problems;
    models[k].check(problems);
    for (const std::string& problem : problems) add(k, problem);
    for (std::size_t before = 0; before < k; ++before)
      if (models[before].name == models[k].name)
        add(k, "body.name is also that of body " + std::to_string(before + 1) + "; give each its own");
  }
  if (!text.empty()) throw Error(text);
}

}  // namespace glint
