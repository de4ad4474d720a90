// SPDX-License-Identifier: MIT
// glint body as it is typed: what is learnt, what is refused, which bodies are told to be confusable.
#include <cmath>
#include <cstdio>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "host/apps/commands.hpp"
#include "host/body/confusions.hpp"
#include "host/config/bodies_file.hpp"
#include "tests/unit/config/config_fixture.hpp"

namespace glint {
namespace {

using test::TempFolder;
using ::testing::HasSubstr;

const BodyModel kBody{"drone", {{0.1, 0, 0}, {-0.08, 0.05, 0}, {-0.02, -0.07, 0.035}, {0.03, 0.01, 0.06}}};

class BodyCommand : public ::testing::Test {
 protected:
  /// Standard output, or the error with its exit code.
  std::string run(const std::string& line) {
    CLI::App app("glint");
    apps::add_body(app);
    ::testing::internal::CaptureStdout();
    std::string error;
    try {
      app.parse(line);
    } catch (const UsageError& e) {
      error = std::string("2: ") + e.what();
    } catch (const Error& e) {
      error = std::string("1: ") + e.what();
    }
    const std::string out = ::testing::internal::GetCapturedStdout();
    return folder_.strip(error.empty() ? out : error);
  }
  /// As glint track writes it, with a column more than the command knows.
  std::string record(int frames, double turn_rad) {
    std::string csv = "tick,time_ns,id,x_m,y_m,z_m,residual_px,cameras,aligned,kind,later\n";
    for (int frame = 0; frame < frames; ++frame) {
      const double t = static_cast<double>(frame) / frames;
      const Eigen::Quaterniond turn(Eigen::AngleAxisd(turn_rad * t, Eigen::Vector3d(1, 2, 3).normalized()));
      for (std::size_t m = 0; m < kBody.markers_in_body.size(); ++m) {
        const Eigen::Vector3d p = turn * kBody.markers_in_body[m] + Eigen::Vector3d(turn_rad * t, 0, 1);
        char line[200];
        std::snprintf(line, sizeof line, "%d,%d,%zu,%.7f,%.7f,%.7f,0.1,1+2,,measured,x\n", 10 + 2 * frame,
                      frame, m + 5, p.x(), p.y(), p.z());
        csv += line;
      }
      csv += std::to_string(10 + 2 * frame) + ",0,99,0,0,0,0,1,,predicted,x\n";
    }
    return folder_.write("tracks.csv", csv).string();
  }
  TempFolder folder_;
};

TEST_F(BodyCommand, LearnsWhatMoved) {
  const std::string out = (folder_ / "b.toml").string();
  EXPECT_THAT(run("body learn " + record(120, 2.0) + " --names drone --out " + out),
              HasSubstr("drone: 4 markers, 187 mm across, 120 frames, markers known to 0.10 mm"));
  const auto bodies = read_bodies(out);
  ASSERT_EQ(bodies.size(), 1u);
  EXPECT_EQ(bodies[0].name, "drone");
  const auto same = find_agreements(bodies[0].markers_in_body, kBody.markers_in_body, 1e-5);
  ASSERT_FALSE(same.empty());
  EXPECT_EQ(same[0].markers.size(), 4u);
  EXPECT_THAT(run("body learn " + record(120, 2.0) + " --out " + out), HasSubstr("1: b.toml: exists"));
  EXPECT_THAT(run("body learn " + record(120, 2.0) + " --force --names a,b --out " + out),
              HasSubstr("2: --names: more than the 1 bodies"));
}

TEST_F(BodyCommand, SaysWhyItLearntNothing) {
  const std::string out = " --out " + (folder_ / "b.toml").string();
  EXPECT_THAT(run("body learn " + record(120, 0.01) + out),
              HasSubstr("1: tracks.csv: no body learnt: a group of 4"));
  EXPECT_THAT(run("body learn " + record(20, 2.0) + out), HasSubstr("only 20 frames"));
  EXPECT_EQ(run("body learn " + folder_.write("t.csv", "tick,id,x_m\n").string() + out),
            "1: t.csv:1:1: no column \"y_m\"; record with glint track --output csv:FILE");
  EXPECT_THAT(run("body learn " + folder_.write("t.csv", "tick,id,x_m,y_m,z_m\n1,1,a,0,0\n").string() + out),
              HasSubstr("1: t.csv:2:5: x_m must be a number"));
}

TEST_F(BodyCommand, TellsWhatCanBeConfused) {
  BodyModel twin = kBody;
  twin.name = "twin";
  const auto path = folder_ / "b.toml";
  write_bodies(path, std::vector<BodyModel>{kBody});
  EXPECT_THAT(run("body check " + path.string()),
              HasSubstr("b.toml: ok, 1 body\nno body can be taken for another"));
  write_bodies(path, std::vector<BodyModel>{kBody, twin}, true);
  EXPECT_THAT(
      run("body check " + path.string()),
      HasSubstr("confusable: \"drone\" and \"twin\" are identical, within 0.0 mm: markers 1 as 1, 2 as 2"));
}

}  // namespace
}  // namespace glint
