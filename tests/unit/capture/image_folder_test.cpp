// SPDX-License-Identifier: MIT
// Folders of numbered images: pairing, gaps, time, damage, and what is refused at the door.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "host/capture/image_source.hpp"
#include "tests/support/temp_dir.hpp"
#include "tests/unit/capture/av_fixture.hpp"

namespace glint {
namespace {

using test::encode_image;
using test::encode_pgm;
using test::error_of;
using test::pattern;
using test::ReadSet;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::SizeIs;

ImageSourceOptions at_100_hz(std::vector<std::string> names = {}) {
  ImageSourceOptions options;
  options.camera_names = std::move(names);
  options.rate_hz = 100.0;
  return options;
}

void write_frame(const test::TempDir& dir, const std::string& camera, const std::string& file, unsigned n,
                 FrameSize size = {32, 24}) {
  dir.write(camera + "/" + file, encode_pgm(pattern(size.width_px, size.height_px, n)));
}

struct Reading {
  std::unique_ptr<FrameSource> source;
  std::vector<ReadSet> sets;
  ReadStatus last = ReadStatus::Ok;
};

Reading read(const std::string& location, const ImageSourceOptions& options) {
  Reading reading;
  reading.source = open_image_source(location, options);
  reading.sets = test::read_all(*reading.source, reading.last);
  return reading;
}

std::vector<std::uint64_t> triggers(const Reading& reading) {
  std::vector<std::uint64_t> all;
  for (const ReadSet& set : reading.sets) all.push_back(set.trigger);
  return all;
}

TEST(ImageFolder, PairsFilesByNumberInNumericOrder) {
  const test::TempDir dir;
  for (const unsigned n : {9U, 10U, 11U}) {
    write_frame(dir, "cam1", "img_" + std::to_string(n) + ".pgm", n);
    write_frame(dir, "cam10", std::to_string(n) + ".pgm", n + 100, {16, 8});
    write_frame(dir, "cam2", "000" + std::to_string(n) + ".pgm", n + 50);
  }
  dir.write("truth.csv", "x");
  dir.write("notes/readme.txt", "x");
  const Reading reading = read(dir.string(), at_100_hz());
  EXPECT_EQ(reading.last, ReadStatus::End);
  EXPECT_FALSE(reading.source->live());
  EXPECT_EQ(reading.source->rate_hz(), 100.0);
  ASSERT_THAT(reading.source->cameras(), SizeIs(3));
  EXPECT_EQ(reading.source->cameras()[0].name, "cam1");
  EXPECT_EQ(reading.source->cameras()[1].name, "cam2");
  EXPECT_EQ(reading.source->cameras()[2].name, "cam10");
  EXPECT_EQ(reading.source->cameras()[2].size.width_px, 16U);
  EXPECT_THAT(triggers(reading), ElementsAre(9, 10, 11));
  for (const ReadSet& set : reading.sets) {
    const auto n = static_cast<unsigned>(set.trigger);
    ASSERT_TRUE(set.frames[0] && set.frames[1] && set.frames[2]);
    EXPECT_EQ(set.frames[0]->image.pixels, pattern(32, 24, n).pixels);
    EXPECT_EQ(set.frames[1]->image.pixels, pattern(32, 24, n + 50).pixels);
    EXPECT_EQ(set.frames[2]->image.pixels, pattern(16, 8, n + 100).pixels);
    EXPECT_EQ(set.frames[0]->sequence, n);
    EXPECT_NEAR(set.exposed_s, (n - 9) * 0.01, 1e-9);
  }
  const SourceCounters counters = reading.source->counters();
  EXPECT_EQ(counters.frames, 9U);
  EXPECT_EQ(counters.missing + counters.damaged + counters.duplicated + counters.no_slot, 0U);
  EXPECT_EQ(reading.source->problem(), "");
}

TEST(ImageFolder, AGapIsAMissingFrame) {
  const test::TempDir dir;
  for (const unsigned n : {1U, 2U, 3U, 5U}) write_frame(dir, "a", std::to_string(n) + ".pgm", n);
  for (const unsigned n : {2U, 3U, 5U, 6U}) write_frame(dir, "b", std::to_string(n) + ".pgm", n);
  const Reading reading = read(dir.string(), at_100_hz());
  EXPECT_THAT(triggers(reading), ElementsAre(1, 2, 3, 5, 6));
  EXPECT_FALSE(reading.sets[0].frames[1]);
  EXPECT_FALSE(reading.sets[4].frames[0]);
  EXPECT_NEAR(reading.sets[3].exposed_s, 0.04, 1e-9);  // the lost exposure took its time
  // b lacks 1, a lacks 6, both lack 4.
  EXPECT_EQ(reading.source->counters().missing, 4U);
  EXPECT_THAT(reading.source->problem(), HasSubstr("camera a ended after 4 of 5 frames"));
}

TEST(ImageFolder, NumbersInStepsAreNoGaps) {
  const test::TempDir dir;
  for (const unsigned n : {100U, 110U, 120U, 140U}) write_frame(dir, "a", std::to_string(n) + ".pgm", n);
  const Reading reading = read(dir.string(), at_100_hz());
  EXPECT_THAT(triggers(reading), ElementsAre(100, 110, 120, 140));
  EXPECT_EQ(reading.source->counters().missing, 1U);
  EXPECT_NEAR(reading.sets[3].exposed_s, 0.04, 1e-9);
}

TEST(ImageFolder, TheNumberIsTheOneThatTellsFilesApart) {
  const test::TempDir dir;
  for (unsigned n = 0; n < 3; ++n) write_frame(dir, "a", "frame" + std::to_string(n) + "_cam7.pgm", n);
  EXPECT_THAT(triggers(read(dir.string(), at_100_hz())), ElementsAre(0, 1, 2));
}

TEST(ImageFolder, ReadsEveryKindOfFile) {
  const test::TempDir dir;
  const GreyImage image = pattern(32, 24, 1);
  dir.write("pgm/1.PGM", encode_pgm(image));
  dir.write("png/1.png", encode_image("png", "gray", image));
  dir.write("tif/1.tif", encode_image("tiff", "gray", image));
  dir.write("tiff/1.tiff", encode_image("tiff", "gray", image));
  dir.write("bmp/1.bmp", encode_image("bmp", "gray", image));
  dir.write("jpg/1.jpg", encode_image("mjpeg", "yuvj420p", image));
  dir.write("jpeg/1.jpeg", encode_image("mjpeg", "yuvj420p", image));
  const Reading reading = read(dir.string(), at_100_hz());
  ASSERT_THAT(reading.sets, SizeIs(1));
  ASSERT_THAT(reading.sets[0].frames, SizeIs(7));
  for (std::size_t n = 0; n < 7; ++n) {
    ASSERT_TRUE(reading.sets[0].frames[n]) << reading.source->cameras()[n].name;
    if (reading.source->cameras()[n].name.starts_with("jp")) continue;
    EXPECT_EQ(reading.sets[0].frames[n]->image.pixels, image.pixels) << reading.source->cameras()[n].name;
  }
}

TEST(ImageFolder, TakesTheRigsOrderAndSubset) {
  const test::TempDir dir;
  write_frame(dir, "a", "0.pgm", 1);
  write_frame(dir, "b", "0.pgm", 2);
  write_frame(dir, "c", "0.pgm", 3);
  const Reading reading = read(dir.string(), at_100_hz({"c", "a"}));
  ASSERT_THAT(reading.source->cameras(), SizeIs(2));
  EXPECT_EQ(reading.sets[0].frames[0]->image.pixels, pattern(32, 24, 3).pixels);
  EXPECT_EQ(reading.sets[0].frames[1]->image.pixels, pattern(32, 24, 1).pixels);
}

TEST(ImageFolder, NamesThatDoNotMatchAreListedOnBothSides) {
  const test::TempDir dir;
  write_frame(dir, "a", "0.pgm", 1);
  write_frame(dir, "b", "0.pgm", 2);
  const std::string text = error_of([&] { open_image_source(dir.string(), at_100_hz({"a", "north"})); });
  EXPECT_THAT(text, HasSubstr("the rig wants a, north"));
  EXPECT_THAT(text, HasSubstr("the source has a, b"));
}

TEST(ImageFolder, AnotherSizeThanTheRigSaysIsRefused) {
  const test::TempDir dir;
  write_frame(dir, "a", "0.pgm", 1);
  write_frame(dir, "b", "0.pgm", 2);
  ImageSourceOptions options = at_100_hz({"a", "b"});
  options.camera_sizes = {{32, 24}, {1280, 800}};
  const std::string text = error_of([&] { open_image_source(dir.string(), options); });
  EXPECT_THAT(text, HasSubstr("camera b: " + (dir.path() / "b" / "0.pgm").string() +
                              " is 32x24, but the rig says 1280x800"));
  EXPECT_THAT(text, Not(HasSubstr("camera a")));
  options.camera_sizes = {{32, 24}, {0, 0}};
  EXPECT_NO_THROW(open_image_source(dir.string(), options));
}

class DamagedFrame : public ::testing::TestWithParam<std::pair<const char*, const char*>> {};

TEST_P(DamagedFrame, IsLeftOutCountedAndNamed) {
  const auto [encoder, pixel_format] = GetParam();
  const test::TempDir dir;
  for (unsigned n = 0; n < 4; ++n) {
    const std::string whole = encode_image(encoder, pixel_format, pattern(64, 48, n));
    dir.write("a/" + std::to_string(n) + ".png", n == 2 ? whole.substr(0, whole.size() / 2) : whole);
    dir.write("b/" + std::to_string(n) + ".png", whole);
  }
  const Reading reading = read(dir.string(), at_100_hz());
  EXPECT_EQ(reading.last, ReadStatus::End);
  ASSERT_THAT(reading.sets, SizeIs(4));
  for (std::size_t n = 0; n < 4; ++n) {
    EXPECT_EQ(reading.sets[n].frames[0].has_value(), n != 2);
    EXPECT_TRUE(reading.sets[n].frames[1]);
  }
  EXPECT_EQ(reading.source->counters().damaged, 1U);
  EXPECT_EQ(reading.source->counters().missing, 0U);
  EXPECT_EQ(reading.source->counters().frames, 7U);
  EXPECT_THAT(reading.source->problem(), HasSubstr("camera a: " + (dir.path() / "a" / "2.png").string()));
}

INSTANTIATE_TEST_SUITE_P(All, DamagedFrame,
                         ::testing::Values(std::pair("png", "gray"), std::pair("tiff", "gray"),
                                           std::pair("mjpeg", "yuvj420p"), std::pair("bmp", "gray"),
                                           std::pair("pgm", "gray")),
                         [](const auto& format) { return std::string(format.param.first); });

TEST(ImageFolder, AFrameOfAnotherSizeIsDamaged) {
  const test::TempDir dir;
  write_frame(dir, "a", "0.pgm", 0);
  write_frame(dir, "a", "1.pgm", 1, {33, 24});
  write_frame(dir, "a", "2.pgm", 2);
  const Reading reading = read(dir.string(), at_100_hz());
  ASSERT_THAT(reading.sets, SizeIs(3));
  EXPECT_FALSE(reading.sets[1].frames[0]);
  EXPECT_EQ(reading.source->counters().damaged, 1U);
  EXPECT_THAT(reading.source->problem(), HasSubstr("1.pgm: is 33x24, but"));
}

TEST(ImageFolder, AnUnreadableFirstFrameIsRefused) {
  const test::TempDir dir;
  write_frame(dir, "a", "0.pgm", 0);
  dir.write("b/0.pgm", "P5\n32 24\n255\nshort");
  const std::string text = error_of([&] { open_image_source(dir.string(), at_100_hz()); });
  EXPECT_THAT(text, HasSubstr("camera b: " + (dir.path() / "b" / "0.pgm").string() + ": damaged"));
}

TEST(ImageFolder, ManyDamagedFilesAreSummedUp) {
  const test::TempDir dir;
  write_frame(dir, "a", "0.pgm", 0);
  write_frame(dir, "b", "30.pgm", 0);
  for (int n = 1; n < 30; ++n) dir.write("a/" + std::to_string(n) + ".pgm", "P5\n32 24\n255\nshort");
  const Reading reading = read(dir.string(), at_100_hz());
  EXPECT_EQ(reading.source->counters().damaged, 29U);
  EXPECT_THAT(reading.source->problem(), HasSubstr("and 17 more like these"));
  EXPECT_THAT(reading.source->problem(), HasSubstr("camera a ended after 30 of 31 frames"));
}

TEST(ImageFolder, DeepImagesAreScaledAndThatIsSaid) {
  const test::TempDir dir;
  const GreyImage image = pattern(32, 24, 1);
  dir.write("a/0.tif", encode_image("tiff", "gray16le", image));
  const Reading reading = read(dir.string(), at_100_hz());
  EXPECT_EQ(reading.sets[0].frames[0]->image.pixels, image.pixels);
  EXPECT_THAT(reading.source->problem(), HasSubstr("scaled to 8 bits"));
}

TEST(ImageFolder, WithoutAnyRateItSaysWhatItAssumes) {
  const test::TempDir dir;
  for (unsigned n = 0; n < 4; ++n) write_frame(dir, "a", std::to_string(n) + ".pgm", n);
  const Reading reading = read(dir.string(), {});
  EXPECT_EQ(reading.source->rate_hz(), 0.0);
  EXPECT_NEAR(reading.sets[3].exposed_s, 0.1, 1e-8);
  EXPECT_THAT(reading.source->problem(), HasSubstr("30 Hz"));
}

TEST(FramesCsv, GivesSequenceAndTime) {
  const test::TempDir dir;
  for (unsigned n = 0; n < 4; ++n) {
    write_frame(dir, "a", std::to_string(n) + ".pgm", n);
    write_frame(dir, "b", std::to_string(n) + ".pgm", n + 10);
  }
  dir.write("frames.csv",
            "camera,frame,sequence,time_ns\n"
            "a,0,50,1000000\na,1,51,2000000\na,2,53,4000000\na,3,53,4000000\n"
            "b,0,50,1000000\nb,1,52,3000000\nb,2,53,4000000\nb,3,54,\n");
  const Reading reading = read(dir.string(), at_100_hz());
  EXPECT_THAT(triggers(reading), ElementsAre(50, 51, 52, 53, 54));
  EXPECT_NEAR(reading.sets[0].exposed_s, 1e-3, 1e-12);
  EXPECT_NEAR(reading.sets[2].exposed_s, 3e-3, 1e-12);
  EXPECT_NEAR(reading.sets[4].exposed_s, 14e-3, 1e-12);  // one nominal period after the last stamp
  EXPECT_FALSE(reading.sets[1].frames[1]);
  EXPECT_FALSE(reading.sets[2].frames[0]);
  EXPECT_EQ(reading.sets[3].frames[0]->image.pixels, pattern(32, 24, 2).pixels);  // not its duplicate
  EXPECT_EQ(reading.sets[3].frames[1]->image.pixels, pattern(32, 24, 12).pixels);
  EXPECT_EQ(reading.sets[3].frames[1]->sequence, 53U);
  EXPECT_EQ(reading.source->counters().duplicated, 1U);
  EXPECT_EQ(reading.source->counters().missing, 3U);
}

TEST(FramesCsv, MustNameEveryFrameAndOnlyKnownCameras) {
  const test::TempDir dir;
  write_frame(dir, "a", "0.pgm", 0);
  write_frame(dir, "a", "1.pgm", 1);
  write_frame(dir, "b", "0.pgm", 1);
  dir.write("frames.csv", "camera,frame,sequence\na,0,0\na,1,1\n");
  EXPECT_THAT(error_of([&] { open_image_source(dir.string(), at_100_hz()); }),
              HasSubstr("no line for camera b"));
  EXPECT_NO_THROW(open_image_source(dir.string(), at_100_hz({"a"})));
  dir.write("frames.csv", "camera,frame,sequence\na,0,0\nb,0,0\n");
  EXPECT_THAT(error_of([&] { open_image_source(dir.string(), at_100_hz()); }),
              HasSubstr("no line for frame 1 of camera a"));
  dir.write("frames.csv", "camera,frame,sequence\na,0,0\nz,0,0\n");
  EXPECT_THAT(error_of([&] { open_image_source(dir.string(), at_100_hz()); }), HasSubstr("frames.csv:3:1"));
}

TEST(ImageFolder, WhatIsNoRecordingIsRefused) {
  const test::TempDir dir;
  const auto refused = [&](const std::string& location) {
    return error_of([&] { open_image_source(location, at_100_hz()); });
  };
  EXPECT_THAT(refused(""), HasSubstr("needs a folder"));
  EXPECT_THAT(refused(dir.string() + "/none"), HasSubstr("no such file or folder"));
  EXPECT_THAT(refused(dir.string()), HasSubstr("holds no cameras"));
  dir.write("1.pgm", "x");
  EXPECT_THAT(refused(dir.string()), HasSubstr("1 images lie beside each other"));
  dir.write("a/picture.pgm", encode_pgm(pattern(8, 8, 0)));
  EXPECT_THAT(refused(dir.string()), HasSubstr("has a number in its name"));
  dir.write("a/1.pgm", encode_pgm(pattern(8, 8, 0)));
  dir.write("a/01.pgm", encode_pgm(pattern(8, 8, 0)));
  EXPECT_THAT(refused(dir.string()), HasSubstr("has the same number as"));
  ImageSourceOptions bad;
  bad.rate_hz = -1;
  EXPECT_THAT(error_of([&] { open_image_source(dir.string(), bad); }), HasSubstr("rate_hz"));
}

TEST(ImageFolder, FilesWithoutANumberAreReported) {
  const test::TempDir dir;
  write_frame(dir, "a", "0.pgm", 0);
  write_frame(dir, "a", "background.pgm", 0);
  const Reading reading = read(dir.string(), at_100_hz());
  EXPECT_THAT(reading.sets, SizeIs(1));
  EXPECT_THAT(reading.source->problem(), HasSubstr("background.pgm: ignored"));
}

TEST(ImageList, FoldersAndFilesMayBeListedWithNames) {
  const test::TempDir dir;
  for (unsigned n = 0; n < 2; ++n) {
    write_frame(dir, "x", std::to_string(n) + ".pgm", n);
    write_frame(dir, "y", std::to_string(n) + ".pgm", n + 7);
  }
  const std::string x = (dir.path() / "x").string(), y = (dir.path() / "y").string();
  const Reading named = read("left=" + x + ",right=" + y, at_100_hz({"right", "left"}));
  EXPECT_EQ(named.sets[1].frames[0]->image.pixels, pattern(32, 24, 8).pixels);
  const Reading numbered = read(x + "," + y, at_100_hz());
  EXPECT_EQ(numbered.source->cameras()[1].name, "cam2");
  const Reading as_the_rig = read(x + "," + y, at_100_hz({"north", "south"}));
  EXPECT_EQ(as_the_rig.source->cameras()[1].name, "south");
  EXPECT_EQ(as_the_rig.sets[1].frames[1]->image.pixels, pattern(32, 24, 8).pixels);
  EXPECT_THAT(error_of([&] { open_image_source(x + ",", at_100_hz()); }), HasSubstr("an empty entry"));
  EXPECT_THAT(error_of([&] { open_image_source(x + ",http://127.0.0.1:1/", at_100_hz()); }),
              HasSubstr("cannot be mixed"));
  EXPECT_THAT(error_of([&] {
                open_image_source(x + "," + y + "," + x, at_100_hz({"a", "b"}));
              }),
              HasSubstr("the source has cam1, cam2, cam3"));
}

TEST(ImageFolder, WaitsForSlotsInsteadOfDropping) {
  const test::TempDir dir;
  for (unsigned n = 0; n < 2; ++n) write_frame(dir, "a", std::to_string(n) + ".pgm", n);
  const auto source = open_image_source(dir.string(), at_100_hz());
  FramePool pool(test::sizes_of(*source), 1);
  FrameSet first, second;
  ASSERT_EQ(source->read(pool, first), ReadStatus::Ok);
  std::jthread slow([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    first.frames[0].reset();
  });
  ASSERT_EQ(source->read(pool, second), ReadStatus::Ok);
  EXPECT_TRUE(second.frames[0]);
  EXPECT_EQ(source->counters().no_slot, 0U);
}

}  // namespace
}  // namespace glint
