// SPDX-License-Identifier: MIT
// Once warm, sinks and recorder allocate nothing per tick.
#include <atomic>
#include <cstdlib>
#include <new>
#include <vector>

#include <gtest/gtest.h>

#include "host/output/blob_sink.hpp"
#include "host/output/report_recorder.hpp"
#include "host/output/track_sink.hpp"

namespace {
std::atomic<long> allocations{0};
}  // namespace

// The whole program counts; GCC sees malloc behind a new expression and warns of a mismatch that is none.
#pragma GCC diagnostic ignored "-Wmismatched-new-delete"
void* operator new(std::size_t bytes) {
  ++allocations;
  if (void* memory = std::malloc(bytes == 0 ? 1 : bytes)) return memory;
  throw std::bad_alloc();
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace glint {
namespace {

TEST(Allocation, TheCounterCounts) {
  const long before = allocations;
  auto something = std::make_unique<std::vector<int>>(100);
  something->resize(1000);
  EXPECT_GE(allocations - before, 3);
}

TEST(Allocation, NonePerTick) {
  std::vector<TrackedPoint> points(64);
  for (std::size_t i = 0; i < points.size(); ++i) points[i].id = TrackId(static_cast<std::uint32_t>(i + 1));
  const std::vector<IdentityEvent> identity(16);
  const std::vector<shaders::BlobRecord> blobs(200);
  const std::vector<CameraCalibration> cameras(4);
  const auto csv = make_track_sink({OutputKind::Csv, "/dev/null"});
  const auto jsonl = make_track_sink({OutputKind::Jsonl, "/dev/null"});
  const auto blob_csv = make_blob_sink({OutputKind::Csv, "/dev/null"}, cameras);
  const auto blob_jsonl = make_blob_sink({OutputKind::Jsonl, "/dev/null"}, cameras);
  RecorderOptions options;
  options.max_bins = 16;  // folded many times below
  ReportRecorder recorder(options);
  long before = 0;
  for (int tick = 0; tick < 1000; ++tick) {
    if (tick == 10) before = allocations;
    const Timestamp exposed{std::chrono::milliseconds(tick * 700)};
    for (const auto* sink : {&csv, &jsonl}) {
      TrackRow row{TriggerNo(static_cast<std::uint64_t>(tick)), exposed, points};
      row.identity = identity;
      ASSERT_EQ((*sink)->write(row), SinkStatus::Ok);
    }
    for (const auto* sink : {&blob_csv, &blob_jsonl}) {
      ASSERT_EQ((*sink)->write({TriggerNo(0), CameraId(3), blobs, false}), SinkStatus::Ok);
    }
    recorder.add({exposed, points, 1e-3, 2e-3});
  }
  EXPECT_EQ(allocations - before, 0);
}

}  // namespace
}  // namespace glint
