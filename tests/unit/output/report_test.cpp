// SPDX-License-Identifier: MIT
// The report page: complete in itself, well-formed, and true to its data.
#include "host/output/report.hpp"

#include <sys/stat.h>

#include <filesystem>
#include <limits>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/base/error.hpp"
#include "host/output/report_chart.hpp"
#include "host/output/report_scene.hpp"
#include "tests/unit/output/scratch_folder.hpp"
#include "tests/unit/page/well_formed.hpp"

namespace glint {
namespace {

using test::ScratchFolder;
using test::text_of;
using test::unbalanced;
using testing::HasSubstr;
using testing::Not;

ReportData small_report() {
  ReportData data;
  data.title = "A <run> & more";
  data.subtitle = "two cameras";
  data.summary = {{"Rate", "90 Hz", "of 90", true}, {"Ghosts", "0"}};
  data.nominal_rate_hz = 90;
  for (int i = 0; i < 2; ++i) {
    CameraCalibration camera;
    camera.name = i == 0 ? "north" : "";
    camera.width_px = 1280;
    camera.height_px = 800;
    camera.fx_px = camera.fy_px = 900;
    camera.cx_px = 640;
    camera.cy_px = 400;
    camera.world_from_camera.translation = {i * 2.0, 0, 2};
    data.cameras.push_back(camera);
  }
  data.trajectories.push_back({TrackId(12), {{{0, 0, 1}, {0.5, 0.1, 1.1}}, {{1, 1, 1}}}});
  data.trajectories.push_back({TrackId(13), {{{1, 0, 1}, {0.5, 0.6, 1.1}}}});
  data.rates = {{0, 90, 2}, {1, 45, 1}, {2, 90, 2}};
  for (int i = 1; i <= 100; ++i) data.end_to_end.add(i * 1e-4);
  return data;
}

TEST(Report, IsWellFormedAndEscaped) {
  const std::string html = report_html(small_report());
  EXPECT_EQ(unbalanced(html), "");
  EXPECT_THAT(html, HasSubstr("A &lt;run&gt; &amp; more"));
  EXPECT_THAT(html, Not(HasSubstr("<run>")));
  EXPECT_NE(unbalanced(html + "</p>"), "");  // the check can fail
}

TEST(Report, NeedsNothingButItself) {
  const std::string html = report_html(small_report());
  for (const char* outside : {"http:", "https:", "//cdn", " src=", "<link", "@import", "url(", "fetch("}) {
    EXPECT_THAT(html, Not(HasSubstr(outside))) << outside;
  }
}

TEST(Report, ShowsCamerasTracksAndFigures) {
  const std::string html = report_html(small_report());
  for (const char* wanted : {">north<", ">camera 2<", "track 12", "track 13", "x (m)", "y (m)", "z (m)",
                             "90 Hz", "nominal 90", "latency (ms)", "p99 ", "not measured in this run"}) {
    EXPECT_THAT(html, HasSubstr(wanted)) << wanted;
  }
}

TEST(Report, EmptyRunStillGivesAPage) {
  const std::string html = report_html(ReportData{});
  EXPECT_EQ(unbalanced(html), "");
  EXPECT_THAT(html, Not(HasSubstr("nan")));
  EXPECT_THAT(html, Not(HasSubstr("inf\"")));
}

TEST(Report, BrokenNumbersDoNotReachThePicture) {
  ReportData data = small_report();
  data.cameras[0].world_from_camera.translation.x() = std::numeric_limits<double>::quiet_NaN();
  data.cameras[1].fx_px = 0.0;
  const std::string html = report_html(data);
  EXPECT_THAT(html, Not(HasSubstr("? ")));
  EXPECT_THAT(html, Not(HasSubstr("nan")));
}

TEST(ReportScene, AStrayPointDoesNotShrinkThePicture) {
  ReportData data = small_report();
  std::vector<Eigen::Vector3d> many(1000, Eigen::Vector3d(0.5, 0.5, 1));
  data.trajectories.push_back({TrackId(14), {many}});
  const std::string before = top_scene_svg(data).substr(0, 400);  // the grid
  data.trajectories.push_back({TrackId(15), {{{1e4, -1e4, 1e4}}}});
  EXPECT_EQ(top_scene_svg(data).substr(0, 400), before);
}

TEST(ReportScene, OnlyTheObliqueViewCarriesWorldCoordinates) {
  const ReportData data = small_report();
  EXPECT_THAT(oblique_scene_svg(data), HasSubstr("0 0 1 0.5 0.1 1.1;1 1 1\""));
  EXPECT_THAT(top_scene_svg(data), Not(HasSubstr("data-p")));
}

TEST(ReportChart, DurationsAreShort) {
  EXPECT_EQ(duration_text(0.0012345), "1.23 ms");
  EXPECT_EQ(duration_text(0.0123), "12.3 ms");
  EXPECT_EQ(duration_text(1.5), "1.50 s");
  EXPECT_EQ(duration_text(0.0001234), "123 \u00b5s");
}

TEST(ReportFile, IsRefusedBeforeTheRun) {
  ScratchFolder folder;
  EXPECT_THROW(ReportFile(folder / "none/r.html", false), Error);
  EXPECT_THROW(ReportFile(folder.path().string(), false), Error);
  EXPECT_THROW(ReportFile("", false), Error);
  std::ofstream(folder / "r.html") << "old";
  EXPECT_THROW(ReportFile(folder / "r.html", false), Error);
  EXPECT_EQ(text_of(folder / "r.html"), "old");
}

TEST(ReportFile, AppearsWholeOrNotAtAll) {
  ScratchFolder folder;
  { ReportFile never_written(folder / "r.html", false); }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
  std::ofstream(folder / "r.html") << "old";
  {
    ReportFile file(folder / "r.html", true);
    EXPECT_EQ(text_of(folder / "r.html"), "old");
    file.write(small_report());
  }
  EXPECT_EQ(text_of(folder / "r.html"), report_html(small_report()));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

TEST(ReportFile, DoesNotReplaceAFileThatAppearedMeanwhile) {
  ScratchFolder folder;
  ReportFile file(folder / "r.html", false);
  std::ofstream(folder / "r.html") << "new";
  EXPECT_THROW(file.write(small_report()), Error);
  EXPECT_EQ(text_of(folder / "r.html"), "new");
}

}  // namespace
}  // namespace glint
