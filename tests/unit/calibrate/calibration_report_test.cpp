// SPDX-License-Identifier: MIT
// The report of a simulated calibration: page, JSON and files.
#include "host/calibrate/calibration_report.hpp"

#include <cmath>
#include <filesystem>
#include <limits>
#include <random>

#include <nlohmann/json.hpp>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/base/error.hpp"
#include "host/calibrate/evaluate.hpp"
#include "host/calibrate/report/camera_charts.hpp"
#include "host/calibrate/report/extent.hpp"
#include "host/calibrate/report/heat.hpp"
#include "host/calibrate/report/plan_view.hpp"
#include "host/calibrate/report/rig_charts.hpp"
#include "host/calibrate/sample_points.hpp"
#include "host/files/text_file.hpp"
#include "host/sim/rig.hpp"
#include "tests/unit/output/scratch_folder.hpp"
#include "tests/unit/page/well_formed.hpp"

namespace glint {
namespace {

using nlohmann::json;
using test::ScratchFolder;
using test::unbalanced;
using testing::HasSubstr;
using testing::Not;

constexpr double kNoise_px = 0.1;

/// A wand waved before the simulated rig, which is calibrated as exactly as `sd` says.
struct Taken {
  Calibration calibration;
  SampleSet samples;
  CalibrationUncertainty uncertainty;

  explicit Taken(unsigned cameras = 4, double noise_px = kNoise_px, int ticks = 1200) {
    SimOptions options;
    options.cameras = cameras;
    calibration = sim_calibration(options);
    const std::vector<Camera> seen_by(calibration.cameras.begin(), calibration.cameras.end());
    samples.target = wand_target({0.0, 0.13, 0.39}, 0.0);
    for (const CameraCalibration& c : calibration.cameras)
      samples.cameras.push_back({c.name, c.width_px, c.height_px});
    std::mt19937_64 random(5);
    std::normal_distribution<double> noise(0.0, noise_px);
    std::uniform_real_distribution<double> place(-1.0, 1.0);
    for (int t = 0; t < ticks; ++t) {
      const Eigen::Vector3d at(1.8 * place(random), 1.8 * place(random), 1.1 + place(random));
      const Eigen::Vector3d axis = Eigen::Vector3d(place(random), place(random), place(random)).normalized();
      for (std::uint32_t c = 0; c < seen_by.size(); ++c) {
        for (std::uint32_t k = 0; k < 3; ++k) {
          const auto pixel = seen_by[c].project(at + samples.target.points_in_target[k].x() * axis);
          if (!pixel || !seen_by[c].inside(*pixel)) continue;
          samples.sightings.push_back(
              {static_cast<std::uint64_t>(t), c, k, *pixel + Eigen::Vector2d(noise(random), noise(random))});
        }
      }
    }
    const Eigen::Index size = 6 * static_cast<Eigen::Index>(cameras);
    Eigen::VectorXd sd(size);
    for (Eigen::Index i = 0; i < size; ++i) sd[i] = i % 6 < 3 ? 2e-5 : 1e-4;
    uncertainty.covariance = sd.cwiseAbs2().asDiagonal();
    uncertainty.sigma_px = noise_px;
  }

  CalibrationReport report() const {
    return make_calibration_report("Rig <A> & more", samples, calibration,
                                   evaluate(calibration, samples, true), uncertainty,
                                   {"one camera <was> late"});
  }
};

TEST(CalibrationReport, ComputesWhatItShows) {
  const Taken taken;
  const CalibrationReport report = taken.report();
  EXPECT_EQ(report.judgement.verdict, Verdict::Excellent) << report.judgement.rule;
  ASSERT_EQ(report.sd.size(), 4u);
  EXPECT_EQ(report.coverage.size(), 4u);
  EXPECT_EQ(report.overlap.cameras(), 4u);
  EXPECT_GT(report.sample_points_in_world.size(), 1000u);
  EXPECT_GT(report.expected.total_m.count, 400u);
  EXPECT_GT(report.expected.noise_m.p50, report.expected.calibration_m.p50);
  EXPECT_GT(report.level.error_m.size(), 2000u);
  EXPECT_NEAR(report.level.centre_in_world(0, 0).z(), 1.1, 0.2);
}

TEST(CalibrationReport, PageIsWellFormedAndNeedsNothingButItself) {
  for (const unsigned cameras : {4u, 12u}) {
    const std::string html = calibration_report_html(Taken(cameras).report());
    EXPECT_EQ(unbalanced(html), "");
    EXPECT_THAT(html, HasSubstr("Rig &lt;A&gt; &amp; more"));
    EXPECT_THAT(html, HasSubstr("one camera &lt;was&gt; late"));
    EXPECT_THAT(html, HasSubstr("<div class=\"word\">excellent</div>"));
    EXPECT_THAT(html, HasSubstr("excellent means held-out error"));
    EXPECT_THAT(html, HasSubstr("Known length 390 mm"));
    for (const char* outside : {"http:", "https:", "//cdn", " src=", "<link", "@import", "url(", "fetch("})
      EXPECT_THAT(html, Not(HasSubstr(outside))) << outside;
    for (const char* broken : {"nan", "inf\"", "\"?"}) EXPECT_THAT(html, Not(HasSubstr(broken))) << broken;
    for (const char* wanted :
         {"x (m)", "y (m)", "z (m)", "mm rms", "px, median", "shift of", "residual (px)", "p95 "})
      EXPECT_THAT(html, HasSubstr(wanted)) << wanted;
    EXPECT_THAT(html, HasSubstr(">cam" + std::to_string(cameras) + "<"));
  }
}

TEST(CalibrationReport, NothingMeasuredStillGivesAPage) {
  CalibrationReport report;
  report.judgement = judge({&report.quality, {}, nullptr, {}});
  const std::string html = calibration_report_html(report);
  EXPECT_EQ(unbalanced(html), "");
  EXPECT_THAT(html, HasSubstr("<div class=\"word\">refuse</div>"));
  EXPECT_THAT(html, Not(HasSubstr("nan")));
}

TEST(CalibrationReport, BrokenNumbersDoNotReachThePicture) {
  CalibrationReport report = Taken(4, kNoise_px, 100).report();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  report.calibration.cameras[1].world_from_camera.translation.x() = nan;
  report.sample_points_in_world[0].y() = nan;
  report.quality.cameras[2].residuals[0].residual_px.x() = nan;
  const std::string html = calibration_report_html(report);
  EXPECT_EQ(unbalanced(html), "");
  EXPECT_THAT(html.substr(html.find("The rig")), Not(HasSubstr("=\"?\"")));
}

TEST(CalibrationReport, JsonHoldsTheSameFigures) {
  const CalibrationReport report = Taken().report();
  const json j = json::parse(calibration_report_json(report));
  EXPECT_EQ(j.at("verdict"), "excellent");
  EXPECT_EQ(j.at("rule"), report.judgement.rule);
  EXPECT_EQ(j.at("criteria").size(), report.judgement.criteria.size());
  EXPECT_EQ(j.at("held_out_rms_px").get<double>(), report.quality.held_out_rms_px);
  ASSERT_EQ(j.at("cameras").size(), 4u);
  const json& camera = j.at("cameras").at(2);
  EXPECT_EQ(camera.at("name"), "cam3");
  EXPECT_EQ(camera.at("held_out_px").at("p95").get<double>(), report.quality.cameras[2].held_out_px.p95);
  EXPECT_EQ(camera.at("orientation_sd_rad").get<double>(), report.sd[2].orientation_rad);
  EXPECT_EQ(camera.at("samples_in_cells").at(4).at(7).get<std::uint64_t>(), report.coverage[2].count(7, 4));
  EXPECT_EQ(j.at("lengths").at(0).at("true_m").get<double>(), report.quality.lengths[0].true_m);
  EXPECT_EQ(j.at("common_ticks").at(1).at(3).get<std::uint64_t>(), report.overlap.ticks(1, 3));
  EXPECT_EQ(j.at("expected_error").at("total_m").at("p50").get<double>(), report.expected.total_m.p50);
  const json& slice = j.at("expected_error").at("level_slice").at("rms_m");
  ASSERT_EQ(slice.size(), report.level.error_m.size());
  EXPECT_TRUE(slice.at(0).is_number() || slice.at(0).is_null());
  EXPECT_EQ(j.at("notes").at(0), "one camera <was> late");
}

TEST(CalibrationReport, JsonSaysNullForWhatIsNotKnown) {
  CalibrationReport report;
  report.title = "bad \xff text";
  report.quality.fit_rms_px = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(json::parse(calibration_report_json(report)).at("fit_rms_px").is_null());
}

TEST(CalibrationReport, FilesAreWholeAndNotReplacedUnasked) {
  const ScratchFolder folder;
  const CalibrationReport report = Taken(4, kNoise_px, 60).report();
  write_calibration_report(folder / "r.html", report, false);
  write_calibration_report(folder / "r.json", report, false);
  EXPECT_EQ(read_text_file(folder / "r.html", 1 << 24), calibration_report_html(report));
  EXPECT_EQ(read_text_file(folder / "r.json", 1 << 24), calibration_report_json(report));
  EXPECT_THROW(write_calibration_report(folder / "r.html", report, false), Error);
  EXPECT_NO_THROW(write_calibration_report(folder / "r.html", report, true));
  EXPECT_THROW(write_calibration_report(folder / "r.pdf", report, false), Error);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 2);
}

TEST(SamplePoints, AreWhereTheTargetWas) {
  const Taken taken(4, 1e-6, 300);
  const auto all = sample_points(taken.calibration, taken.samples, 100'000);
  const auto some = sample_points(taken.calibration, taken.samples, 90);
  EXPECT_GT(all.size(), 500u);
  EXPECT_LE(some.size(), 100u);
  EXPECT_GE(some.size(), 50u);
  for (const Eigen::Vector3d& p : all) EXPECT_LT(p.cwiseAbs().head<2>().maxCoeff(), 1.8 + 0.39 + 1e-3);
}

/// Against cameras drawn from the covariance.
TEST(CameraSd, AgreesWithASimulation) {
  Taken taken(4, kNoise_px, 1);
  std::mt19937_64 random(9);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd mixing = Eigen::MatrixXd::NullaryExpr(24, 24, [&] { return 1e-4 * normal(random); });
  taken.uncertainty.covariance = mixing * mixing.transpose();
  const std::vector<CameraSd> sd = camera_sd(taken.calibration, taken.uncertainty);
  constexpr int kTimes = 4000;
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  double angle2 = 0.0;
  const Pose truth = taken.calibration.cameras[1].world_from_camera.inverse();
  for (int k = 0; k < kTimes; ++k) {
    const Eigen::VectorXd d = mixing * Eigen::VectorXd::NullaryExpr(24, [&] { return normal(random); });
    const Eigen::Vector3d turn = d.segment<3>(6);
    const Pose wrong{Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.normalized())) * truth.rotation,
                     truth.translation + d.segment<3>(9)};
    squares += (wrong.inverse().translation - truth.inverse().translation).cwiseAbs2() / kTimes;
    angle2 += turn.squaredNorm() / kTimes;
  }
  for (int axis = 0; axis < 3; ++axis)
    EXPECT_NEAR(sd[1].position_m[axis] / std::sqrt(squares[axis]), 1.0, 0.05) << axis;
  EXPECT_NEAR(sd[1].orientation_rad / std::sqrt(angle2), 1.0, 0.05);
  EXPECT_TRUE(camera_sd(taken.calibration, {}).empty());
}

TEST(ResidualGrid, StrayOnesDoNotColourACell) {
  std::vector<PixelResidual> residuals;
  for (int i = 0; i < 20; ++i) residuals.push_back({{10, 10}, {0.1, i % 2 == 0 ? 0.01 : -0.01}});
  residuals.push_back({{10, 10}, {30, 40}});
  residuals.push_back({{1270, 790}, {1, 1}, 0, 0, false, true});
  const ResidualGrid grid(residuals, 1280, 800);
  EXPECT_EQ(grid.count(0, 0), 21u);
  EXPECT_NEAR(grid.median_px(0, 0), 0.1005, 1e-3);
  EXPECT_NEAR(grid.shift_px(0, 0).x(), 0.1, 1e-9);
  EXPECT_EQ(grid.count(15, 9), 0u) << "outliers are left out";
  const ResidualScale scale = residual_scale(std::vector<ResidualGrid>{grid});
  EXPECT_GE(scale.top_px, 0.1);
  EXPECT_LE(scale.top_px, 0.2);
  EXPECT_EQ(unbalanced(residual_map_svg(grid, scale)), "");
}

TEST(Charts, ScalesEndRound) {
  EXPECT_DOUBLE_EQ(round_top(0.23), 0.3);
  EXPECT_DOUBLE_EQ(round_top(1.0), 1.0);
  EXPECT_DOUBLE_EQ(round_top(870), 1000);
  EXPECT_DOUBLE_EQ(round_top(0.0), 1.0);
  EXPECT_NE(heat_colour(0.0), heat_colour(1.0));
  EXPECT_EQ(heat_colour(1.0), heat_colour(7.0));
  EXPECT_EQ(heat_colour(0.0), "#26548c");
}

TEST(Charts, PlanKeepsDirectionsAndSeparatesNames) {
  const PlanView above(PlanAxes::FromAbove, {-2, -1, 0}, {2, 1, 3}, 560, 520);
  EXPECT_GT(above({1, 0, 0}).x(), above({0, 0, 0}).x());
  EXPECT_LT(above({0, 1, 0}).y(), above({0, 0, 0}).y()) << "y points up";
  EXPECT_NEAR(above({1, 0, 0}).x() - above({0, 0, 0}).x(), above.units_per_m(), 1e-9);
  const PlanView side(PlanAxes::FromTheSide, {-2, -1, 0}, {2, 1, 3}, 560, 520);
  EXPECT_LT(side({0, 0, 1}).y(), side({0, 0, 0}).y()) << "z points up";
  Calibration three = sim_calibration({});
  for (CameraCalibration& camera : three.cameras) camera.world_from_camera.translation = {0, 0, 2};
  const std::string names = side.cameras(three.cameras);
  std::set<std::string> heights;
  for (std::size_t at = 0; (at = names.find("<text", at)) != std::string::npos; ++at) {
    const std::size_t y = names.find(" y=\"", at);
    heights.insert(names.substr(y, names.find('"', y + 4) - y));
  }
  EXPECT_EQ(heights.size(), 4u);
}

TEST(Charts, AStrayPointDoesNotShrinkThePicture) {
  const Calibration calibration = sim_calibration({});
  std::vector<Eigen::Vector3d> points(1000, Eigen::Vector3d(0, 0, 1));
  const ReportExtent before = report_extent(calibration, points);
  points.push_back({1e4, 1e4, 1e4});
  const ReportExtent after = report_extent(calibration, points);
  EXPECT_EQ(before.high_in_world, after.high_in_world);
  EXPECT_EQ(before.low_in_world.z(), 0.0) << "the floor";
}

TEST(Charts, HistogramAddsUpAndCutsNothingOff) {
  Histogram histogram;
  histogram.values = {-5, 0.05, 0.05, 7, std::numeric_limits<double>::quiet_NaN()};
  histogram.unit = "px";
  histogram.marks = {{"p95 1", 0.9}, {"max 2", 0.95}};
  const std::string svg = histogram_svg(histogram);
  EXPECT_EQ(unbalanced(svg), "");
  std::size_t bars = 0;
  for (std::size_t at = 0; (at = svg.find("class=\"bar\"", at)) != std::string::npos; ++at) ++bars;
  EXPECT_EQ(bars, 3u) << "first, third and last";
  EXPECT_THAT(histogram_svg({}), HasSubstr("nothing measured"));
}

TEST(Charts, CamerasWithoutCommonSamplesStandOut) {
  Overlap overlap(3);
  for (int i = 0; i < 40; ++i) overlap.add(std::vector<std::uint32_t>{0, 1});
  const std::vector<std::string> three{"a", "b", "c"};
  EXPECT_THAT(overlap_svg(overlap, three), HasSubstr(">40<"));
  EXPECT_THAT(overlap_svg(overlap, three), HasSubstr("class=\"nominal\""));
  Overlap many(12);
  const std::vector<std::string> twelve(12, "cam");
  EXPECT_THAT(overlap_svg(many, twelve), HasSubstr("var(--refuse)"));
}

}  // namespace
}  // namespace glint
