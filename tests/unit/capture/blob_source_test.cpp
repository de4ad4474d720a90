// SPDX-License-Identifier: MIT
// Blobs from CSV files: pairing by tick, optional columns, streaming, and the place of every fault.
#include "host/capture/blob_source.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>

#include "tests/support/temp_dir.hpp"
#include "tests/unit/capture/av_fixture.hpp"

namespace glint {
namespace {

using test::error_of;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

BlobSourceOptions at_100_hz() { return {{}, 100.0}; }

TEST(BlobSource, PairsByTickAndTellsTheTime) {
  const test::TempDir dir;
  dir.write("cam1.csv", "tick,x_px,y_px,area_px,sum\n0,1.5,2.25,12,900\n0,3,4,1,2\n2,5,6,1,1\n");
  dir.write("cam2.csv", "tick,x_px,y_px,area_px,sum\n1,7,8,3,30\n2,9,10,3,30\n");
  dir.write("notes.txt", "not a camera");
  const auto source = open_blob_source(dir.string(), at_100_hz());
  ASSERT_THAT(source->cameras(), SizeIs(2));
  EXPECT_EQ(source->cameras()[0].name, "cam1");
  EXPECT_EQ(source->cameras()[0].size.width_px, 0U);

  BlobSet set;
  ASSERT_EQ(source->read(set), ReadStatus::Ok);
  EXPECT_EQ(number(set.trigger), 0U);
  ASSERT_THAT(set.cameras[0], SizeIs(2));
  EXPECT_THAT(set.cameras[1], IsEmpty());
  EXPECT_EQ(set.cameras[0][0].x_px, 1.5F);
  EXPECT_EQ(set.cameras[0][0].y_px, 2.25F);
  EXPECT_EQ(set.cameras[0][0].area_px, 12U);
  EXPECT_EQ(set.cameras[0][0].sum, 900U);
  EXPECT_EQ(set.cameras[0][0].camera, 0U);

  ASSERT_EQ(source->read(set), ReadStatus::Ok);
  EXPECT_EQ(number(set.trigger), 1U);
  EXPECT_THAT(set.cameras[0], IsEmpty());
  ASSERT_THAT(set.cameras[1], SizeIs(1));
  EXPECT_EQ(set.cameras[1][0].camera, 1U);
  EXPECT_EQ(set.exposed.time_since_epoch(), std::chrono::milliseconds(10));

  ASSERT_EQ(source->read(set), ReadStatus::Ok);
  EXPECT_THAT(set.cameras[0], SizeIs(1));
  EXPECT_EQ(source->read(set), ReadStatus::End);
  EXPECT_EQ(source->read(set), ReadStatus::End);
  EXPECT_EQ(source->problem(), "");
}

TEST(BlobSource, HeaderAreaAndSumMayBeMissingAndTicksMaySkip) {
  const test::TempDir dir;
  dir.write("a.csv", "7,1,2\n1000000000000,-3.5,4e1\n");
  dir.write("b.csv", "sum,y_px,x_px,tick\n5,2,1,7\n");
  dir.write("c.csv", "");
  const auto source = open_blob_source(dir.string(), at_100_hz());
  BlobSet set;
  ASSERT_EQ(source->read(set), ReadStatus::Ok);
  EXPECT_EQ(number(set.trigger), 7U);
  EXPECT_EQ(set.cameras[0][0].area_px, 0U);
  EXPECT_EQ(set.cameras[1][0].sum, 5U);
  EXPECT_EQ(set.cameras[1][0].x_px, 1.0F);
  EXPECT_EQ(set.cameras[1][0].y_px, 2.0F);
  EXPECT_THAT(set.cameras[2], IsEmpty());
  ASSERT_EQ(source->read(set), ReadStatus::Ok);
  EXPECT_EQ(number(set.trigger), 1'000'000'000'000U);
  EXPECT_EQ(set.cameras[0][0].x_px, -3.5F);
  EXPECT_EQ(set.cameras[0][0].y_px, 40.0F);
}

TEST(BlobSource, TakesTheRigsOrder) {
  const test::TempDir dir;
  dir.write("a.csv", "0,1,1\n");
  dir.write("b.csv", "0,2,2\n");
  const auto source = open_blob_source(dir.string(), {{"b", "a"}, 1.0});
  BlobSet set;
  ASSERT_EQ(source->read(set), ReadStatus::Ok);
  EXPECT_EQ(set.cameras[0][0].x_px, 2.0F);
  EXPECT_EQ(set.cameras[0][0].camera, 0U);
  EXPECT_THAT(error_of([&] {
                open_blob_source(dir.string(), {{"a", "z"}, 1.0});
              }),
              HasSubstr("the source has a, b"));
}

TEST(BlobSource, TensOfThousandsOfBlobsInOneTick) {
  const test::TempDir dir;
  constexpr std::size_t kBlobs = 40'000;
  std::string content;
  for (std::size_t n = 0; n < kBlobs; ++n) content += "3," + std::to_string(n) + ".25,7\n";
  dir.write("a.csv", content);
  const auto source = open_blob_source(dir.string(), at_100_hz());
  BlobSet set;
  ASSERT_EQ(source->read(set), ReadStatus::Ok);
  ASSERT_THAT(set.cameras[0], SizeIs(kBlobs));
  EXPECT_EQ(set.cameras[0][kBlobs - 1].x_px, static_cast<float>(kBlobs - 1) + 0.25F);
  EXPECT_EQ(source->read(set), ReadStatus::End);
}

TEST(BlobSource, FaultsInTheFirstLinesThrow) {
  const struct {
    const char* content;
    const char* text;
  } faults[] = {
      {"tick,x_px\n", "a.csv:1:10: column \"y_px\" is missing"},
      {"tick,x_px,y_px,hue\n", "a.csv:1:16: unknown column \"hue\""},
      {"tick,x_px,y_px,tick\n", "a.csv:1:16: column \"tick\" occurs twice"},
      {"0,1\n", "a.csv:1:4: y_px is missing"},
      {"0,1,2,3,4,5\n", "a.csv:1:11: too many columns"},
      {"0,1,nan\n", "a.csv:1:5: y_px must be finite"},
      {"0,1,2e9\n", "a.csv:1:5: y_px is not within"},
      {"-1,1,2\n", "a.csv:1:1: tick must be a whole number"},
      {"0,1,2,-5\n", "a.csv:1:7: area_px must be a whole number"},
      {"0,1,2,5000000000\n", "a.csv:1:7: area_px must be at most"},
      {"", "all blob files are empty"},
  };
  for (const auto& fault : faults) {
    const test::TempDir dir;
    dir.write("a.csv", fault.content);
    EXPECT_THAT(error_of([&] { open_blob_source(dir.string(), at_100_hz()); }), HasSubstr(fault.text));
  }
  const test::TempDir dir;
  EXPECT_THAT(error_of([&] { open_blob_source(dir.string(), at_100_hz()); }), HasSubstr("no CSV files"));
  EXPECT_THAT(error_of([&] { open_blob_source(dir.string() + "/nowhere", at_100_hz()); }),
              HasSubstr("No such"));
  EXPECT_THAT(error_of([&] { open_blob_source(dir.string(), {{}, -1.0}); }), HasSubstr("rate_hz"));
}

TEST(BlobSource, LaterFaultsEndTheReadingWithTheirPlace) {
  const struct {
    const char* content;
    const char* text;
  } faults[] = {
      {"0,1,2\n1,x,2\n", "a.csv:2:3: x_px must be a number, not \"x\""},
      {"5,1,2\n4,1,2\n", "a.csv:2:1: tick goes back from 5 to 4"},
      {"0,1,2\n1,1,2,3\n", "a.csv:2:7: too many columns"},
  };
  for (const auto& fault : faults) {
    const test::TempDir dir;
    dir.write("a.csv", fault.content);
    const auto source = open_blob_source(dir.string(), at_100_hz());
    BlobSet set;
    ReadStatus status = ReadStatus::Ok;
    for (int n = 0; n < 4 && status == ReadStatus::Ok; ++n) status = source->read(set);
    EXPECT_EQ(status, ReadStatus::Failed);
    EXPECT_THAT(source->problem(), HasSubstr(fault.text));
    EXPECT_EQ(source->read(set), ReadStatus::Failed);
  }
}

TEST(BlobSource, SaysThatItAssumesARate) {
  const test::TempDir dir;
  dir.write("a.csv", "3,1,2\n");
  const auto source = open_blob_source(dir.string(), {});
  EXPECT_THAT(source->problem(), HasSubstr("30 Hz"));
  BlobSet set;
  ASSERT_EQ(source->read(set), ReadStatus::Ok);
  EXPECT_EQ(set.exposed.time_since_epoch(), std::chrono::milliseconds(100));
}

}  // namespace
}  // namespace glint
