// SPDX-License-Identifier: MIT
// Files of calibration samples: numbers come back bit for bit, and whatever is wrong is named with its line.
#include "host/calibrate/samples.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <tuple>

#include "host/base/error.hpp"
#include "host/sim/random.hpp"
#include "tests/support/temp_dir.hpp"

namespace glint::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Target board() {
  Target target;
  target.kind = TargetKind::Board;
  target.name = "chessboard:3x2:25mm";
  target.points_in_target.clear();
  for (int i = 0; i < 6; ++i) target.points_in_target.emplace_back(0.025 * (i % 3), 0.1 / 3.0 * (i / 3), 0.0);
  return target;
}

SampleSet samples_of(const Target& target) {
  SampleSet samples;
  samples.target = target;
  samples.cameras = {{"north", 1280, 800}, {"S\"\xc3\xbc\"d", 640, 400}};
  samples.rate_hz = 1000.0 / 7.0;
  sim::Random random(5);
  for (const std::uint64_t tick :
       {std::uint64_t{0}, std::uint64_t{3}, std::numeric_limits<std::uint64_t>::max()})
    for (std::uint32_t camera = 0; camera < 2; ++camera)
      for (std::uint32_t point = 0; point < target.points_in_target.size(); ++point)
        samples.sightings.push_back(
            {tick, camera, point, {random.uniform(-1.0, 1280.0), random.uniform(-1.0, 800.0)}});
  samples.sightings.front().pixel = {std::numeric_limits<double>::denorm_min(), 1.0 / 3.0};
  samples.sightings.back().pixel = {12345678901234567890.0, 400.0};
  return samples;
}

void expect_same_bits(double a, double b) {
  EXPECT_EQ(std::bit_cast<std::uint64_t>(a), std::bit_cast<std::uint64_t>(b)) << a << " " << b;
}

std::string text_of(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// What reading throws; empty if it does not.
std::string complaint(const std::filesystem::path& path) {
  try {
    (void)read_samples(path);
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

const std::string kHeader =
    R"({"format":1,"kind":"glint samples","rate_hz":10,"target":{"kind":"wand","name":"w","marker_radius_m":0,)"
    R"("points_in_target_m":[[0,0,0],[0.5,0,0]]},"cameras":[{"name":"a","width_px":640,"height_px":400},)"
    R"({"name":"b","width_px":640,"height_px":400}]})";

std::string header_with(const std::string& from, const std::string& to) {
  std::string text = kHeader;
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

class Samples : public ::testing::Test {
 protected:
  std::filesystem::path file() const { return folder_.path() / "waved.jsonl"; }
  std::string complaint_of(const std::string& text) const {
    return complaint(folder_.write("bad.jsonl", text));
  }
  TempDir folder_;
};

TEST_F(Samples, ComeBackBitForBit) {
  for (const Target& target : {marker_target(0.1 / 3.0), wand_target({0.0, 0.13, 0.39}, 0.0063), board()}) {
    const SampleSet written = samples_of(target);
    write_samples(file(), written, true);
    const SampleSet read = read_samples(file());
    EXPECT_EQ(read.target.kind, target.kind);
    EXPECT_EQ(read.target.name, target.name);
    expect_same_bits(read.target.marker_radius_m, target.marker_radius_m);
    ASSERT_EQ(read.target.points_in_target.size(), target.points_in_target.size());
    for (std::size_t i = 0; i < target.points_in_target.size(); ++i)
      for (Eigen::Index k = 0; k < 3; ++k)
        expect_same_bits(read.target.points_in_target[i][k], target.points_in_target[i][k]);
    expect_same_bits(read.rate_hz, written.rate_hz);
    ASSERT_EQ(read.cameras.size(), 2u);
    for (std::size_t c = 0; c < 2; ++c) {
      EXPECT_EQ(read.cameras[c].name, written.cameras[c].name);
      EXPECT_EQ(read.cameras[c].width_px, written.cameras[c].width_px);
      EXPECT_EQ(read.cameras[c].height_px, written.cameras[c].height_px);
    }
    ASSERT_EQ(read.sightings.size(), written.sightings.size());
    for (std::size_t i = 0; i < read.sightings.size(); ++i) {
      const Sighting &a = read.sightings[i], &b = written.sightings[i];
      EXPECT_EQ(std::tuple(a.tick, a.camera, a.point), std::tuple(b.tick, b.camera, b.point));
      expect_same_bits(a.pixel.x(), b.pixel.x());
      expect_same_bits(a.pixel.y(), b.pixel.y());
    }
  }
}

TEST_F(Samples, AnExistingFileIsRefusedAndKept) {
  const std::filesystem::path kept = folder_.write("waved.jsonl", "precious\n");
  EXPECT_THROW(write_samples(kept, samples_of(board()), false), Error);
  EXPECT_EQ(text_of(kept), "precious\n");
  write_samples(kept, samples_of(board()), true);
  EXPECT_EQ(complaint(kept), "");
}

TEST_F(Samples, WhatIsNotFiniteIsNotWritten) {
  for (const double bad : {kNan, kInfinity, -kInfinity}) {
    SampleSet pixels = samples_of(board());
    pixels.sightings[4].pixel.y() = bad;
    EXPECT_THROW(write_samples(file(), pixels, false), Error);
    SampleSet places = samples_of(board());
    places.target.points_in_target[1].x() = bad;
    EXPECT_THROW(write_samples(file(), places, false), Error);
    SampleSet rate = samples_of(board());
    rate.rate_hz = bad;
    EXPECT_THROW(write_samples(file(), rate, false), Error);
  }
  EXPECT_FALSE(std::filesystem::exists(file()));
}

TEST_F(Samples, AreSortedWhenRead) {
  folder_.write("waved.jsonl", kHeader + "\n[7,1,0,1,2]\n\n[7,0,1,3,4]\n[7,0,0,5,6]\n[2,1,1,7,8]\n");
  const SampleSet samples = read_samples(file());
  ASSERT_EQ(samples.sightings.size(), 4u);
  EXPECT_EQ(samples.sightings[0].pixel, Eigen::Vector2d(7, 8));
  EXPECT_EQ(samples.sightings[1].pixel, Eigen::Vector2d(5, 6));
  EXPECT_EQ(samples.sightings[2].pixel, Eigen::Vector2d(3, 4));
  EXPECT_EQ(samples.sightings[3].pixel, Eigen::Vector2d(1, 2));
  const std::vector<SampleTick> ticks = ticks_of(samples);
  ASSERT_EQ(ticks.size(), 2u);
  EXPECT_EQ(ticks[0].tick, 2u);
  EXPECT_EQ(ticks[0].sightings.size(), 1u);
  EXPECT_EQ(ticks[1].tick, 7u);
  EXPECT_EQ(ticks[1].sightings.size(), 3u);
}

TEST_F(Samples, AHeaderAloneIsGood) {
  folder_.write("waved.jsonl", kHeader);
  EXPECT_TRUE(read_samples(file()).sightings.empty());
  EXPECT_TRUE(ticks_of(read_samples(file())).empty());
}

TEST_F(Samples, BadHeadersAreNamed) {
  EXPECT_THAT(complaint(folder_.path() / "none.jsonl"), HasSubstr("none.jsonl: cannot be read"));
  EXPECT_THAT(complaint_of(""), HasSubstr("bad.jsonl: is empty"));
  EXPECT_THAT(complaint_of("\n\n"), HasSubstr("bad.jsonl: is empty"));
  const std::vector<std::tuple<std::string, std::string>> bad{
      {"tick,x,y", "parse error"},
      {"[1,2,3]", "header"},
      {"{}", "kind"},
      {header_with("glint samples", "glint tracks"), "no file of calibration samples"},
      {header_with("\"format\":1", "\"format\":2"), "format 2"},
      {header_with("\"wand\"", "\"baton\""), "target.kind"},
      {header_with("[[0,0,0],[0.5,0,0]]", "[]"), "points_in_target_m is empty"},
      {header_with("[0.5,0,0]", "[0.5,0]"), "points_in_target_m"},
      {header_with("[0.5,0,0]", "[0.5,0,0,1]"), "points_in_target_m"},
      {header_with("\"marker_radius_m\":0", "\"marker_radius_m\":-1"), "marker_radius_m"},
      {header_with("\"rate_hz\":10", "\"rate_hz\":-10"), "rate_hz"},
      {header_with("\"rate_hz\":10", "\"rate_hz\":null"), "rate_hz"},
      {kHeader.substr(0, kHeader.find("\"cameras\"")) + "\"cameras\":[]}", "lists no cameras"},
      {kHeader.substr(0, kHeader.find(",\"cameras\"")) + "}", "cameras"},
      {header_with("\"width_px\":640", "\"width_px\":-640"), "width_px"},
      {header_with("\"width_px\":640", "\"width_px\":640.5"), "width_px"},
      {header_with("\"name\":\"b\"", "\"name\":\"a\""), "two cameras named a"}};
  for (const auto& [text, what] : bad) {
    const std::string found = complaint_of("\n" + text + "\n[1,0,0,1,2]\n");
    EXPECT_THAT(found, HasSubstr("bad.jsonl:2: ")) << text;
    EXPECT_THAT(found, HasSubstr(what)) << text;
  }
}

TEST_F(Samples, BadRowsAreNamed) {
  const std::vector<std::tuple<std::string, std::string>> bad{
      {"[1,2,0,1,2]", "no camera 2"},
      {"[1,0,2,1,2]", "no point 2"},
      {"[1,-1,0,1,2]", "camera"},
      {"[1,4294967296,0,1,2]", "camera"},
      {"[1,0,4294967296,1,2]", "point"},
      {"[1,0.5,0,1,2]", "camera"},
      {"[-1,0,0,1,2]", "tick"},
      {"[1.5,0,0,1,2]", "tick"},
      {"[1,0,0,1]", "expected [tick, camera, point, x_px, y_px]"},
      {"[1,0,0,1,2,3]", "expected [tick, camera, point, x_px, y_px]"},
      {"{}", "expected [tick, camera, point, x_px, y_px]"},
      {"[1,0,0,\"1\",2]", "x_px"},
      {"[1,0,0,null,2]", "x_px"},
      {"[1,0,0,1,NaN]", "parse error"},
      {"[1,0,0,1,1e999]", "1e999"},
      {"[1,0,0,1,2", "parse error"}};
  for (const auto& [row, what] : bad) {
    const std::string found = complaint_of(kHeader + "\n[0,0,0,1,2]\n" + row + "\n[9,0,0,1,2]\n");
    EXPECT_THAT(found, HasSubstr("bad.jsonl:3: ")) << row;
    EXPECT_THAT(found, HasSubstr(what)) << row;
  }
}

TEST_F(Samples, ATargetThatCannotBeIsRefused) {
  for (const auto& [kind, points, what] : std::vector<std::array<std::string, 3>>{
           {"wand", "[[0,0,0],[0,0,0]]", "0.01 m"},
           {"wand", "[[0,0,0],[0.1,0,0],[0.4,0,0],[1,0,0]]", "two or three markers"},
           {"wand", "[[0,0,0],[0.1,0.2,0]]", "a wand lies on the x axis"},
           {"wand", "[[0,0,0]]", "two or three markers"},
           {"marker", "[[0,0,0],[0.1,0,0]]", "a marker is one point"},
           {"board", "[]", "is empty"}}) {
    const std::string header = R"({"format":1,"kind":"glint samples","target":{"kind":")" + kind +
                               R"(","name":"x","marker_radius_m":0,"points_in_target_m":)" + points +
                               R"(},"rate_hz":0,"cameras":[{"name":"a","width_px":64,"height_px":48}]})";
    EXPECT_THAT(complaint_of(header + "\n"), AllOf(HasSubstr("bad.jsonl:1: "), HasSubstr(what))) << points;
  }
}

TEST_F(Samples, APointListedTwiceIsNamed) {
  const std::string found = complaint_of(kHeader + "\n[5,1,0,1,2]\n[4,1,0,1,2]\n[5,1,1,1,2]\n[5,1,0,3,4]\n");
  EXPECT_THAT(found, HasSubstr("bad.jsonl:5: "));
  EXPECT_THAT(found, HasSubstr("tick 5"));
}

TEST(PutInOrder, KeepsNeitherOfAPointSeenTwice) {
  SampleSet samples;
  samples.sightings = {{3, 0, 1, {1, 1}}, {3, 0, 0, {2, 2}}, {1, 2, 0, {3, 3}}, {3, 0, 1, {4, 4}},
                       {1, 0, 0, {5, 5}}, {1, 2, 0, {6, 6}}, {1, 2, 0, {7, 7}}};
  put_in_order(samples);
  ASSERT_EQ(samples.sightings.size(), 2u);
  EXPECT_EQ(samples.sightings[0].pixel, Eigen::Vector2d(5, 5));
  EXPECT_EQ(samples.sightings[1].pixel, Eigen::Vector2d(2, 2));
}

TEST(HeldOut, IsAFifthInBlocks) {
  int held = 0, changes = 0;
  for (std::uint64_t i = 0; i < 1000; ++i) {
    held += held_out(i);
    changes += i > 0 && held_out(i) != held_out(i - 1);
  }
  EXPECT_EQ(held, 200);
  EXPECT_LE(changes, 40);  // 20 blocks of ten ticks at most
  EXPECT_FALSE(held_out(0));
}

}  // namespace
}  // namespace glint::test
