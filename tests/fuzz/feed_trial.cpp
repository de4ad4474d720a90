// SPDX-License-Identifier: MIT
// A camera's thread against a driver that does what it likes. Its time is the driver's; only the wait for the
// thread is real.
#include <chrono>
#include <vector>

#include "host/base/check.hpp"
#include "host/base/error.hpp"
#include "host/capture/v4l2/camera_feed.hpp"
#include "tests/fuzz/chosen_camera.hpp"
#include "tests/fuzz/v4l2_trials.hpp"
#include "tests/unit/capture/spoilt_calls.hpp"

namespace glint::test {
namespace {

using std::chrono::steady_clock;

constexpr std::uint64_t kCallsARound = 150;
constexpr std::chrono::seconds kHung{20};
constexpr std::uint32_t kSlots = 20;

/// Reads until the thread has asked the driver so often.
void read_on(CameraFeed& feed, WakeUp& reader, FakeV4l2& driver, const SpoiltCalls& calls,
             std::uint64_t& taken) {
  const std::uint64_t enough = calls.calls() + kCallsARound;
  const Timestamp hung_at = steady_clock::now() + kHung;
  while (calls.calls() < enough) {
    GLINT_CHECK(steady_clock::now() < hung_at);
    for (FeedItem item; feed.take(item);) {
      if (item.kind != FeedItem::Kind::Frame) continue;
      ++taken;
      GLINT_CHECK(item.frame.damaged == (item.frame.image().pixels == nullptr));
    }
    driver.with(node_path(0), [](FakeCamera& camera) { camera.plugged = true; });
    reader.wait_until(steady_clock::now() + std::chrono::microseconds(300));
  }
}

}  // namespace

void try_feed(ByteChoices& choices) {
  FakeV4l2 driver;
  choose_camera(choices, driver.add(node_path(0)));
  SpoiltCalls calls(driver, choices, kSpoilt);
  FeedOptions options;
  options.retry = std::chrono::milliseconds(0);
  options.on_event = [](const std::string& text) { GLINT_CHECK(!text.empty()); };
  WakeUp reader;
  try {
    CameraFeed feed(calls, choose_request(choices, node_path(0)), reader, options);
    const FrameSize size = feed.size();
    if (std::uint64_t{size.width_px} * size.height_px > 1'000'000) return;
    if (choices.one_in(2))
      feed.set_limit(std::vector<std::uint8_t>(std::size_t{size.width_px} * size.height_px, 40));
    FramePool pool({size}, kSlots);
    std::uint64_t taken = 0;
    for (int round = 1; round <= 2; ++round) {
      feed.start(pool, CameraId{0});
      read_on(feed, reader, driver, calls, taken);
      feed.stop();
      GLINT_CHECK(all_slots_free(pool, CameraId{0}, kSlots));
      const FeedCounts counts = feed.counts();
      const std::uint64_t known = taken + counts.not_taken +
                                  counts.flaws[static_cast<std::size_t>(FrameFlaw::NoSlot)] +
                                  counts.flaws[static_cast<std::size_t>(FrameFlaw::TooOld)];
      // What lay in the ring when it stopped is not told of.
      GLINT_CHECK(counts.frames >= known &&
                  counts.frames <= known + static_cast<std::uint64_t>(round) * CameraFeed::kRing);
    }
  } catch (const Error& error) {
    GLINT_CHECK(error.what()[0] != '\0');
  }
  GLINT_CHECK(driver.open_nodes() == 0 && driver.mappings() == 0);
}

}  // namespace glint::test
