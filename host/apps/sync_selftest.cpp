// SPDX-License-Identifier: MIT
// Tests an output again and again until its wire is there.
#include "host/apps/sync_selftest.hpp"

#include <algorithm>
#include <chrono>
#include <thread>

#include "host/apps/sync_text.hpp"

namespace glint::apps {
namespace {

double us(sync::Seconds time) { return time.count() * 1e6; }

std::string place_text(std::size_t output) { return sync::output_name(output) + ", " + output_pin(output); }

/// A plug that is just being pushed in makes bad contact: so many tests more before it counts.
sync::SelfTestResult settled(sync::SyncBoard& board, sync::SelfTestResult result) {
  constexpr int kMoreTests = 3;
  const auto output = static_cast<std::size_t>(result.output);
  for (int i = 0; i < kMoreTests && !result.passed(); ++i) result = board.self_test(output);
  return result;
}

sync::SelfTestResult test_when_wired(sync::SyncBoard& board, std::size_t output, const SayLine& say) {
  constexpr std::chrono::milliseconds kPause{100};
  sync::SelfTestResult result = board.self_test(output);
  if (result.seen > 0) return settled(board, result);
  say("connect " + output_pin(output) + " (" + sync::output_name(output) + ") to " + kSyncInPin +
      " (sync in) ...");
  while (result.seen == 0) {
    std::this_thread::sleep_for(kPause);
    result = board.self_test(output);
  }
  return settled(board, result);
}

std::string error_text(const char* what, sync::Seconds sent, sync::Seconds least, sync::Seconds most) {
  return format_text("%s %.3f us, measured %+.3f to %+.3f us off", what, us(sent), us(least - sent),
                     us(most - sent));
}

}  // namespace

std::vector<sync::SelfTestResult> run_self_tests(sync::SyncBoard& board, const SelfTestOptions& options,
                                                 const SayLine& say) {
  std::vector<sync::SelfTestResult> results;
  for (const std::size_t output : options.outputs) {
    const sync::SelfTestResult result =
        options.wait_for_wires ? test_when_wired(board, output, say) : board.self_test(output);
    say(self_test_text(result));
    results.push_back(result);
  }
  return results;
}

std::string self_test_text(const sync::SelfTestResult& r) {
  const std::string place = place_text(static_cast<std::size_t>(r.output)) + ": ";
  if (r.seen == 0) return place + "no wire from there to " + kSyncInPin + " (sync in)";
  std::string text = place + (r.passed() ? "passed" : "FAILED") +
                     format_text(", %u of %u pulses; ", r.seen, r.sent) +
                     error_text("width", r.width, r.least_width, r.most_width);
  if (r.seen > 1) text += "; " + error_text("period", r.period, r.least_period, r.most_period);
  return text + format_text("; the board measures to %.3f us", us(r.resolution));
}

std::string self_test_verdict(const std::vector<sync::SelfTestResult>& results, bool named) {
  std::string failed;
  std::size_t wired = 0;
  for (const sync::SelfTestResult& result : results) {
    if (result.seen > 0) ++wired;
    const bool excused = result.seen == 0 && !named;
    if (!result.passed() && !excused) failed += (failed.empty() ? "" : ", ") + std::to_string(result.output);
  }
  if (!failed.empty()) return "the self-test failed: output " + failed;
  if (wired == 0) return std::string("the self-test found no wire from any output to sync in, ") + kSyncInPin;
  return "";
}

}  // namespace glint::apps
