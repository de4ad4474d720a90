// SPDX-License-Identifier: MIT
// Parameters with their deviations, views, advice.
#include "host/apps/calibrate/intrinsics_report.hpp"

#include <array>
#include <cmath>
#include <cstdio>

#include "host/calibrate/verdict.hpp"

namespace glint::apps {
namespace {

constexpr std::array<const char*, 9> kNames{"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"};

std::array<double, 9> parameters_of(const CameraCalibration& c) {
  const auto& k = c.k1_k2_p1_p2_k3;
  return {c.fx_px, c.fy_px, c.cx_px, c.cy_px, k[0], k[1], k[2], k[3], k[4]};
}

std::string filled(const char* format, auto... values) {
  char text[300];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

}  // namespace

std::string intrinsics_text(const IntrinsicsResult& result) {
  const CameraCalibration& c = result.camera;
  std::size_t corners = 0, used = 0;
  std::string outliers;
  for (const BoardViewResult& view : result.views) {
    if (view.outlier) {
      outliers += (outliers.empty() ? "" : ", ") +
                  filled("%llu (%.2f px)", static_cast<unsigned long long>(view.tick), view.rms_px);
      continue;
    }
    ++used;
    corners += view.corners;
  }
  std::string text =
      filled("%s  %ux%u  %zu views, %zu corners in %.0f %% of the image, %.3f px rms", c.name.c_str(),
             c.width_px, c.height_px, used, corners, 100.0 * result.covered, result.rms_px);
  text += result.held_out_rms_px > 0.0 ? filled(", held-out views %.3f px: ", result.held_out_rms_px)
                                       : std::string(", too few views to hold any back: ");
  text += std::string(word_of(result.verdict)) + "\n";
  const auto values = parameters_of(c);
  for (std::size_t i = 0; i < 9; ++i) {
    if (i >= 4 && values[i] == 0.0 && c.intrinsics_sd[i] == 0.0) continue;
    text += i < 4 ? filled("  %s %.3f +- %.3f px", kNames[i], values[i], c.intrinsics_sd[i])
                  : filled("  %s %.5f +- %.5f", kNames[i], values[i], c.intrinsics_sd[i]);
    if (i == 3 || i == 8) text += "\n";
  }
  if (text.back() != '\n') text += "\n";
  if (!outliers.empty())
    text += "  left out, because they fit far worse than the others: pictures " + outliers + "\n";
  for (const std::string& advice : result.advice) text += "  better with: " + advice + "\n";
  return text;
}

std::string truth_text(const IntrinsicsResult& result, const CameraCalibration& truth) {
  const auto found = parameters_of(result.camera), is = parameters_of(truth);
  std::string text = "  minus the truth:";
  for (std::size_t i = 0; i < 9; ++i) {
    const double sd = result.camera.intrinsics_sd[i];
    text += filled("  %s %+.*f", kNames[i], i < 4 ? 3 : 5, found[i] - is[i]);
    if (sd > 0.0) text += filled(" (%.1f sd)", std::abs(found[i] - is[i]) / sd);
  }
  return text + "\n";
}

nlohmann::ordered_json intrinsics_json(const std::string& board, std::span<const IntrinsicsResult> results) {
  nlohmann::ordered_json all;
  all["kind"] = "glint intrinsics";
  all["format"] = 1;
  all["board"] = board;
  all["cameras"] = nlohmann::ordered_json::array();
  for (const IntrinsicsResult& result : results) {
    const CameraCalibration& c = result.camera;
    nlohmann::ordered_json camera;
    camera["name"] = c.name;
    camera["width_px"] = c.width_px;
    camera["height_px"] = c.height_px;
    const auto values = parameters_of(c);
    for (std::size_t i = 0; i < 9; ++i) {
      camera[kNames[i] + std::string(i < 4 ? "_px" : "")] = values[i];
      camera[kNames[i] + std::string(i < 4 ? "_sd_px" : "_sd")] = c.intrinsics_sd[i];
    }
    camera["rms_px"] = result.rms_px;
    if (result.held_out_rms_px > 0.0) camera["held_out_rms_px"] = result.held_out_rms_px;
    camera["sigma_px"] = result.sigma_px;
    camera["covered"] = result.covered;
    camera["verdict"] = word_of(result.verdict);
    camera["rule"] = result.rule;
    camera["advice"] = result.advice;
    camera["views"] = nlohmann::ordered_json::array();
    for (const BoardViewResult& view : result.views) {
      camera["views"].push_back({{"picture", view.tick},
                                 {"corners", view.corners},
                                 {"rms_px", view.rms_px},
                                 {"left_out", view.outlier},
                                 {"held_out", view.held_out}});
    }
    all["cameras"].push_back(camera);
  }
  return all;
}

}  // namespace glint::apps
