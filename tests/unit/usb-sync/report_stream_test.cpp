// SPDX-License-Identifier: MIT
#include "usb-sync/report_stream.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <vector>

#include "tests/support/allocations.hpp"

namespace glint::sync {
namespace {

constexpr std::uint32_t kEpoch = 11;

InputReport report(std::uint32_t number, std::uint32_t epoch = kEpoch) {
  InputReport report;
  report.epoch = epoch;
  report.report_no = number;
  report.run = 1;
  Triggers triggers;
  triggers.count = 1;
  triggers.list[0].sequence = number;
  report.content = triggers;
  return report;
}

InputReport not_held(std::uint32_t oldest) {
  InputReport answer;
  answer.epoch = kEpoch;
  answer.report_no = oldest;
  answer.content = NotHeld{oldest};
  return answer;
}

class ReportStreamTest : public ::testing::Test {
 protected:
  ReportStreamTest() { stream_.opened(kEpoch, 0); }

  /// The numbers of the reports that are ready.
  std::vector<std::uint32_t> ready() {
    std::vector<std::uint32_t> numbers;
    while (const auto next = stream_.next()) numbers.push_back(next->report.report_no);
    return numbers;
  }

  ReportStream stream_;
};

using Numbers = std::vector<std::uint32_t>;

TEST_F(ReportStreamTest, ReportsInOrderPassAtOnce) {
  for (std::uint32_t i = 0; i < 1000; ++i) {
    stream_.add(report(i));
    EXPECT_EQ(ready(), Numbers{i});
    EXPECT_EQ(stream_.wanted(), std::nullopt);
  }
  EXPECT_EQ(stream_.delivered(), 1000u);
  EXPECT_EQ(stream_.lost(), 0u);
  EXPECT_EQ(stream_.stale(), 0u);
}

TEST_F(ReportStreamTest, MissingOnesAreWantedOneByOneAndMergedInOrder) {
  stream_.add(report(0));
  stream_.add(report(3));
  stream_.add(report(5));
  EXPECT_EQ(ready(), Numbers{0});
  EXPECT_EQ(stream_.wanted(), 1u);
  stream_.add_fetched(report(1));
  EXPECT_EQ(ready(), Numbers{1});
  EXPECT_EQ(stream_.wanted(), 2u);
  stream_.add_fetched(report(2));
  EXPECT_EQ(ready(), (Numbers{2, 3}));
  EXPECT_EQ(stream_.wanted(), 4u);
  stream_.add_fetched(report(4));
  EXPECT_EQ(ready(), (Numbers{4, 5}));
  EXPECT_EQ(stream_.fetched(), 3u);
  EXPECT_EQ(stream_.lost(), 0u);
}

TEST_F(ReportStreamTest, WhatTheBoardForgotIsLostAndToldBeforeTheNext) {
  stream_.add(report(0));
  ready();
  stream_.add(report(10));
  stream_.add_fetched(not_held(7));
  EXPECT_EQ(stream_.lost(), 6u);
  EXPECT_EQ(stream_.wanted(), 7u);
  stream_.add_fetched(report(7));
  const auto next = stream_.next();
  ASSERT_TRUE(next);
  EXPECT_EQ(next->report.report_no, 7u);
  EXPECT_EQ(next->lost_before, 6u);
}

TEST_F(ReportStreamTest, WhatIsHereAlreadyIsNotLostWithTheForgotten) {
  stream_.add(report(3));
  stream_.add_fetched(not_held(900));
  EXPECT_EQ(stream_.lost(), 3u);
  EXPECT_EQ(ready(), Numbers{3});
}

TEST_F(ReportStreamTest, OneThatCannotBeFetchedIsGivenUp) {
  stream_.add(report(2));
  stream_.give_up();
  EXPECT_EQ(stream_.wanted(), 1u);
  stream_.give_up();
  EXPECT_EQ(ready(), Numbers{2});
  EXPECT_EQ(stream_.lost(), 2u);
  stream_.give_up();  // nothing is missing
  EXPECT_EQ(stream_.lost(), 2u);
}

TEST_F(ReportStreamTest, TheWrongAnswerCountsAsLost) {
  stream_.add(report(1));
  stream_.add_fetched(report(7));
  EXPECT_EQ(stream_.lost(), 1u);
  EXPECT_EQ(ready(), Numbers{1});
}

TEST_F(ReportStreamTest, LostOnesAtTheEndShowWhenTheBoardSaysHowManyItWrote) {
  stream_.add(report(0));
  ready();
  EXPECT_EQ(stream_.wanted(), std::nullopt);
  stream_.written(kEpoch, 3);
  EXPECT_EQ(stream_.wanted(), 1u);
  stream_.add_fetched(report(1));
  EXPECT_EQ(ready(), Numbers{1});
  EXPECT_EQ(stream_.wanted(), 2u);
}

TEST_F(ReportStreamTest, OneThatIsNotSentYetIsWaitedFor) {
  stream_.written(kEpoch, 1);
  stream_.add_fetched(not_held(0));  // it still waits in the board
  EXPECT_EQ(stream_.wanted(), std::nullopt);
  EXPECT_EQ(stream_.lost(), 0u);
  stream_.add(report(0));
  EXPECT_EQ(ready(), Numbers{0});
}

TEST_F(ReportStreamTest, RepeatedAndOldOnesAreDropped) {
  stream_.add(report(0));
  stream_.add(report(0));
  stream_.add(report(2));
  stream_.add(report(2));
  ready();
  stream_.add(report(0));
  EXPECT_EQ(stream_.stale(), 3u);
  stream_.add_fetched(report(1));
  EXPECT_EQ(ready(), (Numbers{1, 2}));
}

TEST_F(ReportStreamTest, TheFirstTimeOnlyWhatComesFromNowOnIsWanted) {
  ReportStream stream;
  stream.add(report(4));  // before anything is known
  stream.opened(kEpoch, 500);
  stream.add(report(499));  // a leftover in the board's buffer
  EXPECT_FALSE(stream.next());
  EXPECT_EQ(stream.stale(), 2u);
  stream.add(report(500));
  EXPECT_EQ(stream.next()->report.report_no, 500u);
}

TEST_F(ReportStreamTest, InTheSameEpochAReopenMissesNothing) {
  stream_.add(report(0));
  ready();
  stream_.opened(kEpoch, 4);
  stream_.add(report(4));
  for (std::uint32_t i = 1; i < 4; ++i) {
    EXPECT_EQ(stream_.wanted(), i);
    stream_.add_fetched(report(i));
    EXPECT_EQ(ready(), i < 3 ? Numbers{i} : (Numbers{3, 4}));
  }
  EXPECT_EQ(stream_.wanted(), std::nullopt);
}

TEST_F(ReportStreamTest, ANewEpochIsWantedFromItsBeginningAndTheOldOneIsStale) {
  stream_.add(report(0));
  ready();
  stream_.opened(kEpoch + 5, 2);
  EXPECT_EQ(stream_.epoch(), kEpoch + 5);
  stream_.add(report(1));  // arrives late, from before
  EXPECT_EQ(stream_.stale(), 1u);
  EXPECT_EQ(stream_.wanted(), 0u);
  stream_.add_fetched(report(0, kEpoch + 5));
  EXPECT_EQ(ready(), Numbers{0});
  stream_.add(report(1, kEpoch + 5));
  EXPECT_EQ(ready(), Numbers{1});
}

TEST_F(ReportStreamTest, WhatWasMissingInTheOldEpochIsLost) {
  stream_.add(report(3));
  stream_.opened(kEpoch + 1, 0);
  EXPECT_EQ(stream_.lost(), 4u);  // the one that waited, too
  stream_.add(report(0, kEpoch + 1));
  EXPECT_EQ(stream_.next()->lost_before, 4u);
}

TEST_F(ReportStreamTest, AStrangeEpochMakesItAskWhoIsThere) {
  EXPECT_FALSE(stream_.strange_epoch());
  stream_.add(report(0, kEpoch + 1));
  EXPECT_TRUE(stream_.strange_epoch());
  stream_.opened(kEpoch, 0);  // the same as ever: it was a leftover
  EXPECT_FALSE(stream_.strange_epoch());
  stream_.add(report(0));
  EXPECT_EQ(ready(), Numbers{0});
}

TEST_F(ReportStreamTest, AnAnswerOfAStrangeEpochDoesSoToo) {
  stream_.add(report(1));
  stream_.add_fetched(report(0, kEpoch + 1));
  EXPECT_TRUE(stream_.strange_epoch());
  EXPECT_EQ(stream_.lost(), 1u);  // so that nobody asks for it for ever
  EXPECT_EQ(ready(), Numbers{1});
}

TEST_F(ReportStreamTest, WhenNothingCanBeFetchedTheRestIsHandedOut) {
  stream_.add(report(2));
  stream_.add(report(5));
  EXPECT_EQ(ready(), Numbers{});
  EXPECT_TRUE(stream_.skip_missing());
  EXPECT_EQ(ready(), Numbers{2});
  EXPECT_TRUE(stream_.skip_missing());
  EXPECT_EQ(ready(), Numbers{5});
  EXPECT_FALSE(stream_.skip_missing());
  EXPECT_EQ(stream_.lost(), 4u);
}

TEST_F(ReportStreamTest, TooManyAtOnceAreFetchedLater) {
  constexpr std::uint32_t kMany = ReportStream::kWindow + 100;
  for (std::uint32_t i = 1; i < kMany; ++i) stream_.add(report(i));
  std::uint32_t asked = 0, expected = 0;
  while (const auto number = stream_.wanted()) {
    stream_.add_fetched(report(*number));
    ++asked;
    for (const std::uint32_t n : ready()) EXPECT_EQ(n, expected++);
  }
  EXPECT_EQ(expected, kMany);
  EXPECT_LE(asked, 102u);
  EXPECT_EQ(stream_.lost(), 0u);
}

TEST_F(ReportStreamTest, NumbersOfReportsWrap) {
  ReportStream stream;
  stream.opened(kEpoch, 0xfffffffe);
  std::uint32_t expected = 0xfffffffe;
  for (const std::uint32_t i : {0xfffffffeu, 0xffffffffu, 1u}) stream.add(report(i));
  while (const auto next = stream.next()) EXPECT_EQ(next->report.report_no, expected++);
  EXPECT_EQ(stream.wanted(), 0u);
  stream.add_fetched(report(0));
  while (const auto next = stream.next()) EXPECT_EQ(next->report.report_no, expected++);
  EXPECT_EQ(expected, 2u);
}

TEST_F(ReportStreamTest, NumbersOfTriggersDoNotWrap) {
  const auto send = [this](std::uint32_t number, std::uint16_t run, std::uint32_t sequence) {
    InputReport with = report(number);
    with.run = run;
    std::get<Triggers>(with.content).list[0].sequence = sequence;
    stream_.add(with);
    return stream_.next()->first_sequence;
  };
  EXPECT_EQ(send(0, 1, 0xfffffffe), 0xfffffffeull);
  EXPECT_EQ(send(1, 1, 3), 0x1'0000'0003ull);
  EXPECT_EQ(send(2, 1, 0x80000000), 0x1'8000'0000ull);
  EXPECT_EQ(send(3, 1, 0xf0000000), 0x1'f000'0000ull);
  EXPECT_EQ(send(4, 1, 1), 0x2'0000'0001ull);
  EXPECT_EQ(send(5, 2, 0), 0ull);  // another run begins at 0
  EXPECT_EQ(send(6, 2, 0x7fffffff), 0x7fffffffull);
  EXPECT_EQ(send(7, 2, 0xfffffffe), 0xfffffffeull);
  EXPECT_EQ(send(8, 2, 3), 0x1'0000'0003ull);
  stream_.opened(kEpoch + 1, 0);  // and so does the run of that number in another epoch
  InputReport first = report(0, kEpoch + 1);
  first.run = 2;
  stream_.add(first);
  EXPECT_EQ(stream_.next()->first_sequence, 0ull);
}

TEST_F(ReportStreamTest, WhateverComesItsOutputIsInOrderAndItsCountsAddUp) {
  std::mt19937 engine(5);
  const auto random = [&engine] { return static_cast<std::uint32_t>(engine()); };
  for (int round = 0; round < 200; ++round) {
    auto stream = std::make_unique<ReportStream>();
    stream->opened(kEpoch, 0);
    std::uint32_t written = 0, forgotten = 0;
    std::int64_t last = -1;
    std::uint64_t delivered = 0, lost_told = 0;
    for (int step = 0; step < 500; ++step) {
      switch (random() % 6) {
        case 0:
          written += random() % 3;
          break;  // the host sees nothing of them
        case 1:
          stream->add(report(written > 0 ? random() % written : 0));
          break;  // any, out of order
        case 2:
          stream->written(kEpoch, written);
          break;
        case 3:
          forgotten = std::min(written, forgotten + random() % 4);
          break;
        default:
          stream->add(report(written++));
          break;
      }
      for (int fetch = 0; fetch < 3; ++fetch) {
        const auto number = stream->wanted();
        if (!number) break;
        stream->add_fetched(*number < forgotten ? not_held(forgotten) : report(*number));
      }
      while (const auto next = stream->next()) {
        ASSERT_GT(std::int64_t{next->report.report_no}, last);
        ASSERT_EQ(std::int64_t{next->report.report_no} - last - 1, std::int64_t(next->lost_before));
        last = next->report.report_no;
        lost_told += next->lost_before;
        ++delivered;
      }
    }
    EXPECT_EQ(stream->delivered(), delivered);
    EXPECT_GE(stream->lost(), lost_told);
    EXPECT_GT(delivered, 50u);
  }
}

TEST_F(ReportStreamTest, NothingIsAllocated) {
  const std::size_t before = glint::testing::allocations();
  for (std::uint32_t i = 0; i < 5000; ++i) {
    if (i % 7 != 0) stream_.add(report(i));
    if (const auto number = stream_.wanted()) stream_.add_fetched(report(*number));
    while (stream_.next()) {
    }
  }
  EXPECT_EQ(glint::testing::allocations(), before);
}

}  // namespace
}  // namespace glint::sync
