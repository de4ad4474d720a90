// SPDX-License-Identifier: MIT
// The page of a calibration: the word and its reasons first, then the rig, then each camera.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "host/calibrate/calibration_report.hpp"
#include "host/calibrate/report/camera_charts.hpp"
#include "host/calibrate/report/extent.hpp"
#include "host/calibrate/report/heat.hpp"
#include "host/calibrate/report/rig_charts.hpp"
#include "host/calibrate/report/style.hpp"
#include "host/page/page.hpp"
#include "host/page/page_text.hpp"

namespace glint {
namespace {

std::string fixed(double value, int decimals) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.*f", decimals, value);
  return text.data();
}
std::string px(double value) { return fixed(value, value < 10 ? 3 : 1); }
std::string mm(double value_m) { return fixed(1e3 * value_m, std::abs(value_m) < 0.1 ? 2 : 1); }
std::string degrees(double rad) { return fixed(rad * 180.0 / std::numbers::pi, 4); }

std::string whole(std::uint64_t value) {
  std::string digits = std::to_string(value);
  for (std::size_t at = digits.size(); at > 3; at -= 3) digits.insert(at - 3, ",");
  return digits;
}

std::string tag(const char* name, const char* kind, const std::string& inner) {
  std::string s = std::string("<") + name;
  if (*kind != 0) s += std::string(" class=\"") + kind + "\"";
  return s + ">" + inner + "</" + name + ">";
}

std::string number_cell(const std::string& text) { return tag("td", "n", text); }

std::string card(const std::string& title, const std::string& explanation, const std::string& content) {
  return tag("div", "card",
             tag("h2", "", escape_html(title)) + tag("p", "small", escape_html(explanation)) + content);
}

std::string part(const char* title) { return tag("h2", "part", title); }

std::string verdict_section(const Judgement& judgement) {
  const std::string word = word_of(judgement.verdict);
  std::string rows;
  for (const Criterion& c : judgement.criteria) {
    std::string name = tag("b", "", escape_html(c.name));
    if (c.level != Verdict::Excellent) name += tag("div", "small", escape_html(c.remedy));
    rows += "<tr><td>" + name + "</td><td class=\"whole\">" + escape_html(c.measured) + "</td>";
    for (const std::string& limit : c.limits)
      rows += tag("td", "small whole", limit.empty() ? "" : escape_html(limit));
    rows += "<td>" + tag("span", (std::string("pill ") + word_of(c.level)).c_str(), word_of(c.level)) +
            "</td></tr>";
  }
  return "<section class=\"card verdict " + word + "\"><div class=\"word\">" + word +
         "</div><p class=\"rule\">" + escape_html(judgement.rule) +
         "</p><div "
         "class=\"scroll\"><table><tr><th>figure</th><th>measured</th><th>excellent</th><th>good</th>"
         "<th>poor</th><th></th></tr>" +
         rows + "</table></div></section>";
}

std::string head(const std::string& name, const std::string& value, const std::string& note) {
  return tag("div", "card",
             tag("div", "small", name) + tag("div", "value", value) + tag("span", "small", note));
}

std::string heads_section(const CalibrationReport& report) {
  const CalibrationQuality& q = report.quality;
  const bool proved = q.sightings_held_out > 0;
  std::string s =
      proved ? head("Held-out reprojection error", px(q.held_out_rms_px) + " px rms",
                    "fitted samples: " + px(q.fit_rms_px) + " px")
             : head("Reprojection error of the fit", px(q.fit_rms_px) + " px rms", "nothing was held out");
  if (!q.lengths.empty()) {
    const LengthQuality& longest = *std::max_element(
        q.lengths.begin(), q.lengths.end(), [](const auto& a, const auto& b) { return a.true_m < b.true_m; });
    s += head(proved ? "Held-out length error, p95" : "Length error of the fit, p95",
              mm(longest.error_m.p95) + " mm",
              "of " + short_number(1e3 * longest.true_m, 1) + " mm; the mean is " +
                  mm(longest.mean_m - longest.true_m) + " mm off");
  }
  if (report.expected.total_m.count > 0) {
    s += head("Expected error of a point, median", mm(report.expected.total_m.p50) + " mm",
              "95 % below " + mm(report.expected.total_m.p95) + " mm; by the calibration alone " +
                  mm(report.expected.calibration_m.p50) + " mm");
  }
  s += head("Samples", whole(q.ticks_used) + " ticks", "and " + whole(q.ticks_held_out) + " held out");
  const auto all = static_cast<double>(q.sightings_used + q.sightings_held_out + q.outliers);
  s += head("Left out", whole(q.outliers) + (q.outliers == 1 ? " sighting" : " sightings"),
            all > 0 ? short_number(100.0 * static_cast<double>(q.outliers) / all, 2) + " % of all" : "");
  return tag("section", "heads", s);
}

std::string rig_section(const CalibrationReport& report) {
  const ReportExtent extent = report_extent(report.calibration, report.sample_points_in_world);
  const auto layout = [&](PlanAxes axes) {
    return layout_svg(axes, report.calibration, report.sample_points_in_world, extent.low_in_world,
                      extent.high_in_world);
  };
  // The colours are for where the target was; the rims of the volume may lie beyond.
  const double top_m = round_top(2.0 * report.expected.total_m.p95);
  const auto slice = [&](PlanAxes axes, const ExpectedErrorMap& map) {
    return error_slice_svg(axes, map, top_m, report.calibration, extent.low_in_world, extent.high_in_world);
  };
  const bool known = report.expected.total_m.count > 0;
  std::string s = part("The rig") + "<section class=\"two\">" +
                  card("From above", "Cameras, what they see (wedges), and where the target was (dots).",
                       layout(PlanAxes::FromAbove));
  if (known) {
    s += card("Expected error at z = " + short_number(extent.middle_in_world.z(), 2) + " m",
              "How far a point is from the truth: calibration and noise of one exposure (" +
                  px(report.sigma_px) + " px). Empty: fewer than two cameras see it.",
              slice(PlanAxes::FromAbove, report.level));
  }
  s += card("From the side", "The same, seen along y.", layout(PlanAxes::FromTheSide));
  if (known) {
    s += card("Expected error at y = " + short_number(extent.middle_in_world.y(), 2) + " m",
              "The same in an upright slice along x.", slice(PlanAxes::FromTheSide, report.upright));
  }
  return s + "</section>";
}

std::string summary_cells(const ErrorSummary& s) {
  if (s.count == 0) return std::string("<td class=\"n\">none</td><td></td><td></td><td></td>");
  return number_cell(px(s.mean)) + number_cell(px(s.p50)) + number_cell(px(s.p95)) + number_cell(px(s.max));
}

std::string camera_table(const CalibrationReport& report) {
  std::string rows;
  for (std::size_t i = 0; i < report.quality.cameras.size(); ++i) {
    const CameraQuality& q = report.quality.cameras[i];
    rows += "<tr><td><b>" + escape_html(q.name) + "</b></td>";
    if (i < report.calibration.cameras.size()) {
      const Eigen::Vector3d& at = report.calibration.cameras[i].world_from_camera.translation;
      for (int axis = 0; axis < 3; ++axis) rows += number_cell(fixed(at[axis], 3));
    } else {
      rows += "<td></td><td></td><td></td>";
    }
    rows += number_cell(i < report.sd.size() ? mm(report.sd[i].distance_m()) : "?");
    rows += number_cell(i < report.sd.size() ? degrees(report.sd[i].orientation_rad) : "?");
    rows += summary_cells(q.fit_px) + summary_cells(q.held_out_px) +
            number_cell(whole(q.fit_px.count + q.held_out_px.count)) + number_cell(whole(q.outliers)) +
            "</tr>";
  }
  return "<section class=\"card scroll\" style=\"margin-top:14px\"><table><tr><th></th><th class=\"n\" "
         "colspan=\"3\">position (m)</th>"
         "<th class=\"n\" colspan=\"2\">standard deviation</th><th class=\"n\" colspan=\"4\">fitted (px)</th>"
         "<th class=\"n\" colspan=\"4\">held out (px)</th><th class=\"n\" colspan=\"2\">sightings</th></tr>"
         "<tr><th>camera</th><th class=\"n\">x</th><th class=\"n\">y</th><th class=\"n\">z</th><th "
         "class=\"n\">mm</th>"
         "<th class=\"n\">degrees</th><th class=\"n\">mean</th><th class=\"n\">p50</th><th "
         "class=\"n\">p95</th>"
         "<th class=\"n\">max</th><th class=\"n\">mean</th><th class=\"n\">p50</th><th class=\"n\">p95</th>"
         "<th class=\"n\">max</th><th class=\"n\">used</th><th class=\"n\">left out</th></tr>" +
         rows + "</table></section>";
}

std::string camera_cards(const CalibrationReport& report) {
  std::vector<ResidualGrid> grids;
  double widest = 0.0;
  for (std::size_t i = 0; i < report.quality.cameras.size(); ++i) {
    const CameraCalibration& c = report.calibration.cameras[i];
    grids.emplace_back(report.quality.cameras[i].residuals, c.width_px, c.height_px);
    widest =
        std::max({widest, report.quality.cameras[i].fit_px.p95, report.quality.cameras[i].held_out_px.p95});
  }
  const ResidualScale scale = residual_scale(grids);
  const double high = round_top(1.6 * widest);
  std::string s;
  for (std::size_t i = 0; i < report.quality.cameras.size(); ++i) {
    const CameraQuality& q = report.quality.cameras[i];
    Histogram histogram;
    for (const PixelResidual& residual : q.residuals)
      if (!residual.outlier)
        (residual.held_out ? histogram.outline : histogram.values).push_back(residual.residual_px.norm());
    histogram.high = high;
    histogram.unit = "residual (px); bars: fitted, line: held out";
    histogram.width = 380;
    histogram.what = "residuals of " + q.name;
    if (q.held_out_px.count > 0) histogram.marks = {{"p95 " + px(q.held_out_px.p95), q.held_out_px.p95}};
    std::string covered, where;
    if (i < report.coverage.size()) {
      covered = coverage_svg(report.coverage[i], grids[i].height_px() / grids[i].width_px());
      where = report.coverage[i].sentence();
    }
    s += "<section class=\"card\" style=\"margin-top:14px\"><h2>" + escape_html(q.name) +
         "</h2><div class=\"figures soft\"><span>held out <b>" + px(q.held_out_px.rms) +
         " px rms</b></span><span>fitted " + px(q.fit_px.rms) + " px rms</span><span>" + whole(q.outliers) +
         " left out</span>" + (where.empty() ? "" : tag("span", "", escape_html(where))) +
         "</div><div class=\"three\"><div><h3>residuals over the image, predicted to measured</h3>" +
         residual_map_svg(grids[i], scale) + "</div><div><h3>residuals</h3>" + histogram_svg(histogram) +
         "</div><div><h3>samples over the image</h3>" + covered + "</div></div></section>";
  }
  return s;
}

std::string length_section(const CalibrationReport& report) {
  std::string s;
  for (const LengthQuality& length : report.quality.lengths) {
    Histogram histogram;
    double most = 0.0;
    std::vector<double> absolute;
    for (const double measured : length.measured_m) {
      histogram.values.push_back(1e3 * (measured - length.true_m));
      absolute.push_back(std::abs(histogram.values.back()));
    }
    if (!absolute.empty()) {
      const auto at =
          absolute.begin() + static_cast<std::ptrdiff_t>(0.99 * static_cast<double>(absolute.size() - 1));
      std::nth_element(absolute.begin(), at, absolute.end());
      most = *at;
    }
    histogram.high = round_top(1.1 * most);
    histogram.low = -histogram.high;
    histogram.unit = "measured less true length (mm)";
    histogram.what = "error of the known length";
    const double off_mm = 1e3 * (length.mean_m - length.true_m);
    histogram.marks = {{"mean " + short_number(off_mm, 3), off_mm}};
    const std::string figures = "mean error " + short_number(off_mm, 3) + " mm, standard deviation " +
                                mm(length.sd_m) + " mm; absolute error p50 " + mm(length.error_m.p50) +
                                ", p95 " + mm(length.error_m.p95) + ", max " + mm(length.error_m.max) +
                                " mm; " + whole(length.error_m.count) + " measurements.";
    s += card("Known length " + short_number(1e3 * length.true_m, 2) + " mm", figures,
              histogram_svg(histogram));
  }
  return s;
}

std::string notes_section(const std::vector<std::string>& notes) {
  std::string items;
  for (const std::string& note : notes) items += tag("li", "", escape_html(note));
  return items.empty() ? ""
                       : part("Notes") + "<section class=\"card\" style=\"margin-top:14px\"><ul>" + items +
                             "</ul></section>";
}

}  // namespace

std::string calibration_report_html(const CalibrationReport& report) {
  std::vector<std::string> names;
  for (const CameraCalibration& camera : report.calibration.cameras) names.push_back(camera.name);
  std::string subtitle = report.made_from;
  if (!report.calibration.made_at.empty())
    subtitle += (subtitle.empty() ? "" : ", ") + report.calibration.made_at;
  std::string body = "<header><h1>" + escape_html(report.title) + "</h1><p class=\"soft\">" +
                     escape_html(subtitle) + "</p></header>" + verdict_section(report.judgement) +
                     heads_section(report) + rig_section(report);
  const std::string lengths = length_section(report);
  body += part(report.quality.sightings_held_out > 0 ? "Held-out lengths and common samples"
                                                     : "Lengths of the fit and common samples") +
          "<section class=\"two\">" + lengths;
  if (report.overlap.cameras() > 1) {
    body += card("Common samples", "How often each two cameras saw the target at the same tick.",
                 overlap_svg(report.overlap, names));
  }
  body += "</section>" + part("The cameras") + camera_table(report) + camera_cards(report) +
          notes_section(report.notes);
  return page_html(report.title, kCalibrationStyle, body, "");
}

}  // namespace glint
