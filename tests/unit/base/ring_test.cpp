// SPDX-License-Identifier: MIT
// The ring between two threads: order, bounds, waiting and closing.
#include "host/base/ring.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <memory>
#include <thread>

namespace glint {
namespace {

TEST(Ring, GivesBackInOrderAndHoldsExactlyItsCapacity) {
  Ring<int> ring(3);
  for (int round = 0; round < 5; ++round) {
    EXPECT_TRUE(ring.push(1));
    EXPECT_TRUE(ring.push(2));
    EXPECT_TRUE(ring.push(3));
    EXPECT_EQ(ring.size(), 3U);
    EXPECT_FALSE(ring.push(4));
    int value = 0;
    for (int expected = 1; expected <= 3; ++expected) {
      ASSERT_TRUE(ring.pop(value));
      EXPECT_EQ(value, expected);
    }
    EXPECT_FALSE(ring.pop(value));
    EXPECT_EQ(ring.size(), 0U);
    EXPECT_TRUE(ring.push(9));  // moves the seam on
    EXPECT_TRUE(ring.pop(value));
  }
}

TEST(Ring, ValueIsUntouchedWhenItIsFull) {
  Ring<std::unique_ptr<int>> ring(1);
  EXPECT_TRUE(ring.push(std::make_unique<int>(1)));
  auto second = std::make_unique<int>(2);
  EXPECT_FALSE(ring.push(std::move(second)));
  ASSERT_NE(second, nullptr);
  EXPECT_EQ(*second, 2);
}

TEST(Ring, WhatIsInsideSurvivesClosing) {
  Ring<int> ring(4);
  EXPECT_TRUE(ring.push(1));
  EXPECT_TRUE(ring.push(2));
  ring.close();
  int value = 0;
  EXPECT_TRUE(ring.wait_pop(value));
  EXPECT_TRUE(ring.wait_pop(value));
  EXPECT_EQ(value, 2);
  EXPECT_FALSE(ring.wait_pop(value));
  EXPECT_FALSE(ring.wait_push(3));
}

TEST(Ring, ClosingWakesTheWaitingConsumer) {
  Ring<int> ring(1);
  std::jthread closer([&] { ring.close(); });
  int value = 0;
  EXPECT_FALSE(ring.wait_pop(value));
}

TEST(Ring, ClosingWakesTheWaitingProducer) {
  Ring<int> ring(1);
  EXPECT_TRUE(ring.push(1));
  std::jthread closer([&] { ring.close(); });
  EXPECT_FALSE(ring.wait_push(2));
}

// A lost wake-up would hang here (the test runner's time limit ends it); a race shows under the thread
// sanitizer.
TEST(Ring, NothingIsLostOrReorderedBetweenTwoWaitingThreads) {
  constexpr int kCount = 200'000;
  for (const std::size_t capacity : {std::size_t{1}, std::size_t{2}, std::size_t{7}}) {
    Ring<std::unique_ptr<int>> ring(capacity);
    std::atomic<bool> all_pushed{true};
    std::jthread producer([&] {
      for (int n = 0; n < kCount; ++n) {
        if (!ring.wait_push(std::make_unique<int>(n))) all_pushed = false;
      }
      ring.close();
    });
    int expected = 0;
    for (std::unique_ptr<int> value; ring.wait_pop(value); ++expected) ASSERT_EQ(*value, expected);
    producer.join();
    EXPECT_EQ(expected, kCount);
    EXPECT_TRUE(all_pushed);
  }
}

}  // namespace
}  // namespace glint
