// SPDX-License-Identifier: MIT
// Rows reach the file whole or not at all, and failures are told once and counted.
#include "host/output/record_file.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/base/error.hpp"
#include "tests/unit/output/scratch_folder.hpp"

namespace glint {
namespace {

using test::lines_of;
using test::ScratchFolder;
using test::text_of;
using testing::EndsWith;
using testing::HasSubstr;

std::string refusal(const std::string& path, bool force) {
  try {
    RecordFile file(path, force, "head\n");
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

/// No file of this process grows beyond `bytes` while this lives: a disk that is full.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    ::getrlimit(RLIMIT_FSIZE, &old_);
    rlimit now = old_;
    now.rlim_cur = bytes;
    ::setrlimit(RLIMIT_FSIZE, &now);
    old_handler_ = std::signal(SIGXFSZ, SIG_IGN);
  }
  ~FileSizeLimit() {
    ::setrlimit(RLIMIT_FSIZE, &old_);
    std::signal(SIGXFSZ, old_handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit old_{};
  void (*old_handler_)(int) = nullptr;
};

TEST(RecordFile, WritesNumbersAsSaid) {
  ScratchFolder folder;
  RecordFile file(folder / "a", false);
  file.integer(-5).text(",").unsigned_integer(18446744073709551615u).text(",").number(1.25, 4, "nan");
  file.text(",")
      .number(-0.00004, 4, "nan")
      .text(",")
      .number(std::numeric_limits<double>::quiet_NaN(), 4, "nan");
  file.text(",")
      .number(-std::numeric_limits<double>::infinity(), 4, "null")
      .text(",")
      .number(1e300, 4, "nan");
  file.end_row();
  EXPECT_EQ(file.finish(), SinkStatus::Ok);
  EXPECT_EQ(text_of(folder / "a"), "-5,18446744073709551615,1.2500,-0.0000,nan,null,1e+300\n");
}

TEST(RecordFile, TheHeaderIsThereAtOnceAndIsNoRow) {
  ScratchFolder folder;
  RecordFile file(folder / "a", false, "x,y\n");
  EXPECT_EQ(text_of(folder / "a"), "x,y\n");
  file.text("1,2").end_row();
  EXPECT_EQ(file.flush(), SinkStatus::Ok);
  EXPECT_EQ(text_of(folder / "a"), "x,y\n1,2\n");
  EXPECT_EQ(file.counters().rows_written, 1u);
}

TEST(RecordFile, AnUnfinishedRowStaysOut) {
  ScratchFolder folder;
  {
    RecordFile file(folder / "a", false);
    file.text("1").end_row();
    file.text("half");
    EXPECT_EQ(file.flush(), SinkStatus::Ok);
    EXPECT_EQ(text_of(folder / "a"), "1\n");
    file.text(" and whole").end_row();
    file.text("never ended");
  }
  EXPECT_EQ(text_of(folder / "a"), "1\nhalf and whole\n");
}

TEST(RecordFile, ManyRowsArriveInOrder) {
  ScratchFolder folder;
  RecordFile file(folder / "a", false);
  for (int i = 0; i < 100000; ++i) {
    file.integer(i);
    file.end_row();
    ASSERT_EQ(file.end_group(), SinkStatus::Ok);
  }
  ASSERT_EQ(file.finish(), SinkStatus::Ok);
  const auto lines = lines_of(text_of(folder / "a"));
  ASSERT_EQ(lines.size(), 100000u);
  for (std::size_t i = 0; i < lines.size(); ++i) ASSERT_EQ(lines[i], std::to_string(i));
  EXPECT_EQ(file.counters().rows_written, 100000u);
}

TEST(RecordFile, ALongRowGrowsTheBuffer) {
  ScratchFolder folder;
  RecordFile file(folder / "a", false);
  const std::string row(3'000'000, 'x');
  file.text(row).end_row();
  EXPECT_EQ(file.finish(), SinkStatus::Ok);
  EXPECT_EQ(text_of(folder / "a"), row + "\n");
}

TEST(RecordFile, AnExistingFileIsKeptUnlessForced) {
  ScratchFolder folder;
  std::ofstream(folder / "a") << "precious and long\n";
  EXPECT_THAT(refusal(folder / "a", false), HasSubstr("exists already"));
  EXPECT_EQ(text_of(folder / "a"), "precious and long\n");
  EXPECT_EQ(refusal(folder / "a", true), "");
  EXPECT_EQ(text_of(folder / "a"), "head\n");
}

TEST(RecordFile, AnUnwritablePathSaysWhyAndWhatToDo) {
  ScratchFolder folder;
  std::ofstream(folder / "plain") << "";
  EXPECT_THAT(refusal(folder / "none/a.csv", false), HasSubstr("make its folder first"));
  EXPECT_THAT(refusal(folder / "none/a.csv", false), HasSubstr("none/a.csv"));
  EXPECT_THAT(refusal(folder.path().string(), false), HasSubstr("name a file in it"));
  EXPECT_THAT(refusal(folder / "plain/a.csv", false), HasSubstr("is a file"));
}

TEST(RecordFile, AFullDiskAtTheStartIsAnError) {
  EXPECT_THAT(refusal("/dev/full", false), HasSubstr("No space left on device"));
}

TEST(RecordFile, ADeviceNeedsNoForce) { EXPECT_EQ(refusal("/dev/null", false), ""); }

TEST(RecordFile, AFullDiskLeavesWholeRowsAndIsToldOnce) {
  ScratchFolder folder;
  RecordFile file(folder / "a", false, "head\n");
  {
    FileSizeLimit limit(100'000);
    SinkStatus status = SinkStatus::Ok;
    std::uint64_t rows = 0;
    while (status == SinkStatus::Ok && rows < 100'000) {
      file.text("row ").unsigned_integer(rows++).end_row();
      status = file.end_group();
    }
    EXPECT_EQ(status, SinkStatus::Failed);
    file.text("one more").end_row();
    ++rows;
    EXPECT_EQ(file.end_group(), SinkStatus::Lost);
    EXPECT_EQ(file.counters().rows_written + file.counters().rows_lost, rows);
  }
  EXPECT_THAT(file.problem(), HasSubstr("File too large"));
  EXPECT_THAT(file.problem(), HasSubstr(folder / "a"));
  const std::string text = text_of(folder / "a");
  const auto lines = lines_of(text);
  EXPECT_THAT(text, EndsWith("\n"));
  ASSERT_GT(lines.size(), 5000u);
  EXPECT_EQ(lines.size(), file.counters().rows_written + 1);
  EXPECT_EQ(lines.back(), "row " + std::to_string(lines.size() - 2));
  // Space alone does not heal it: a file with a hole in the middle would look whole.
  file.text("late").end_row();
  EXPECT_EQ(file.finish(), SinkStatus::Lost);
  EXPECT_EQ(text_of(folder / "a"), text);
}

/// Standard output goes elsewhere while this lives.
class RedirectedStdout {
 public:
  explicit RedirectedStdout(int to) : saved_(::dup(STDOUT_FILENO)) { ::dup2(to, STDOUT_FILENO); }
  ~RedirectedStdout() {
    ::dup2(saved_, STDOUT_FILENO);
    ::close(saved_);
  }
  RedirectedStdout(const RedirectedStdout&) = delete;
  RedirectedStdout& operator=(const RedirectedStdout&) = delete;

 private:
  int saved_;
};

TEST(RecordFile, ABrokenPipeIsAStatus) {
  const auto old_handler = std::signal(SIGPIPE, SIG_IGN);
  int ends[2];
  ASSERT_EQ(::pipe(ends), 0);
  SinkStatus first, second, third;
  std::string problem;
  char got[16] = {};
  ssize_t n = 0;
  {
    RedirectedStdout redirected(ends[1]);
    RecordFile file("-", false);
    file.text("1").end_row();
    first = file.end_group();  // a pipe gets each group at once
    n = ::read(ends[0], got, sizeof got);
    ::close(ends[0]);
    file.text("2").end_row();
    second = file.end_group();
    third = file.finish();
    problem = file.problem();
  }
  ::close(ends[1]);
  std::signal(SIGPIPE, old_handler);
  EXPECT_EQ(std::string(got, static_cast<std::size_t>(n)), "1\n");
  EXPECT_EQ(first, SinkStatus::Ok);
  EXPECT_EQ(second, SinkStatus::Failed);
  EXPECT_EQ(third, SinkStatus::Lost);
  EXPECT_THAT(problem, HasSubstr("standard output: cannot write: Broken pipe"));
}

TEST(RecordFile, StandardOutputInAFileIsCutBackToItsOwnLastRow) {
  ScratchFolder folder;
  const int fd = ::open((folder / "out").c_str(), O_WRONLY | O_CREAT, 0666);
  ASSERT_GE(fd, 0);
  ASSERT_EQ(::write(fd, "before\n", 7), 7);
  SinkStatus status;
  {
    RedirectedStdout redirected(fd);
    FileSizeLimit limit(20);
    RecordFile file("-", false);
    file.text("12345").end_row();
    file.text("abcdefghijkl").end_row();
    status = file.flush();
  }
  ::close(fd);
  EXPECT_EQ(status, SinkStatus::Failed);
  EXPECT_EQ(text_of(folder / "out"), "before\n12345\n");
}

TEST(RecordFile, FinishingTwiceIsHarmlessAndLaterRowsAreCounted) {
  ScratchFolder folder;
  RecordFile file(folder / "a", false);
  EXPECT_EQ(file.finish(), SinkStatus::Ok);
  EXPECT_EQ(file.finish(), SinkStatus::Ok);
  file.text("late").end_row();
  EXPECT_EQ(file.end_group(), SinkStatus::Lost);
  EXPECT_EQ(file.counters().rows_lost, 1u);
}

}  // namespace
}  // namespace glint
