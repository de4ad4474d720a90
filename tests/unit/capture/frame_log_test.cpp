// SPDX-License-Identifier: MIT
// frames.csv: what is read, and that every fault is named by file, line and column.
#include "host/capture/frame_log.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/temp_dir.hpp"
#include "tests/unit/capture/av_fixture.hpp"

namespace glint {
namespace {

using ::testing::HasSubstr;

FrameLog read(const test::TempDir& dir, const std::string& content) {
  return {dir.write("frames.csv", content), {"a", "b"}};
}

TEST(FrameLog, ReadsSequenceAndTime) {
  const test::TempDir dir;
  const FrameLog log = read(dir,
                            "camera,frame,sequence,time_ns\n"
                            "# a comment\n"
                            "a,1,10,1000\n"
                            "b, 1 ,10,1001\r\n"
                            "\n"
                            "a,2,12,\n");
  ASSERT_NE(log.find("a", 1), nullptr);
  EXPECT_EQ(log.find("a", 1)->sequence, 10U);
  EXPECT_EQ(log.find("a", 1)->time_ns, 1000);
  EXPECT_EQ(log.find("b", 1)->time_ns, 1001);
  EXPECT_EQ(log.find("a", 2)->sequence, 12U);
  EXPECT_FALSE(log.find("a", 2)->time_ns);
  EXPECT_EQ(log.find("a", 3), nullptr);
  EXPECT_EQ(log.find("c", 1), nullptr);
}

TEST(FrameLog, ColumnsMayComeInAnyOrderAndWithoutTime) {
  const test::TempDir dir;
  const FrameLog log = read(dir, "\xef\xbb\xbfsequence,frame,camera\n7,3,b\n");
  ASSERT_NE(log.find("b", 3), nullptr);
  EXPECT_EQ(log.find("b", 3)->sequence, 7U);
  EXPECT_FALSE(log.has_camera("a"));
}

struct Fault {
  const char* content;
  const char* place;
  const char* words;
};

class FrameLogFault : public ::testing::TestWithParam<Fault> {};

TEST_P(FrameLogFault, IsNamedWithItsPlace) {
  const test::TempDir dir;
  const std::string text = test::error_of([&] { read(dir, GetParam().content); });
  EXPECT_THAT(text, HasSubstr("frames.csv:" + std::string(GetParam().place)));
  EXPECT_THAT(text, HasSubstr(GetParam().words));
}

INSTANTIATE_TEST_SUITE_P(
    All, FrameLogFault,
    ::testing::Values(
        Fault{"", "1", "empty"}, Fault{"camera,frame\n", "1:13", "\"sequence\" is missing"},
        Fault{"camera,frame,sequence,colour\n", "1:23", "unknown column \"colour\""},
        Fault{"camera,frame,frame\n", "1:14", "occurs twice"},
        Fault{"camera,frame,sequence\nc,1,1\n", "2:1", "no camera \"c\" in this recording; there are a, b"},
        Fault{"camera,frame,sequence\na,x,1\n", "2:3", "frame must be a whole number"},
        Fault{"camera,frame,sequence\na,1\n", "2:4", "sequence is missing"},
        Fault{"camera,frame,sequence\na,1,-4\n", "2:5", "sequence must be a whole number"},
        Fault{"camera,frame,sequence\na,2,1\na,2,2\n", "3:3", "must ascend"},
        Fault{"camera,frame,sequence\na,1,5\na,2,4\n", "3:5", "sequence goes back"},
        Fault{"camera,frame,sequence,time_ns\na,1,1,1.5\n", "2:7", "time_ns must be a whole number"},
        Fault{"camera,frame,sequence,time_ns\na,1,1,9000000000000000000\n", "2:7", "within"},
        Fault{"camera,frame,sequence,time_ns\na,1,1,9\na,2,2,8\n", "3:7", "time_ns goes back"}));

}  // namespace
}  // namespace glint
