// SPDX-License-Identifier: MIT
// The exact text of track and blob outputs.
#include <limits>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/base/error.hpp"
#include "host/output/blob_sink.hpp"
#include "host/output/track_sink.hpp"
#include "tests/unit/output/scratch_folder.hpp"

namespace glint {
namespace {

using test::ScratchFolder;
using test::text_of;

static_assert(noexcept(std::declval<TrackSink&>().write(std::declval<const TrackRow&>())));
static_assert(noexcept(std::declval<BlobSink&>().write(std::declval<const BlobRow&>())));

TrackedPoint point(std::uint32_t id, const Eigen::Vector3d& position, double residual_px,
                   std::uint32_t cameras) {
  TrackedPoint p;
  p.id = TrackId(id);
  p.position_in_world = position;
  p.residual_px = residual_px;
  p.cameras = cameras;
  return p;
}

Timestamp at_ns(std::int64_t ns) { return Timestamp(std::chrono::nanoseconds(ns)); }

TEST(TrackSink, CsvHoldsOneRowAPoint) {
  ScratchFolder folder;
  const auto sink = make_track_sink(parse_output_spec("csv:" + (folder / "t.csv")));
  const std::vector<TrackedPoint> points{point(1, {0.1, -2.0, 1.2345678}, 0.04321, 0b1011),
                                         point(4000000000u, {0, 0, 0}, 0, 0x80000001u)};
  EXPECT_EQ(sink->write({TriggerNo(7), at_ns(1'234'567'890'123), points}), SinkStatus::Ok);
  EXPECT_EQ(sink->write({TriggerNo(8), at_ns(1'234'579'000'000), {}}), SinkStatus::Ok);
  EXPECT_EQ(sink->finish(), SinkStatus::Ok);
  EXPECT_EQ(text_of(folder / "t.csv"),
            "tick,time_ns,id,x_m,y_m,z_m,residual_px,cameras,aligned,kind,age,ambiguous,sd_m\n"
            "7,1234567890123,1,0.1000000,-2.0000000,1.2345678,0.0432,1+2+4,,measured,0,,0.00000000\n"
            "7,1234567890123,4000000000,0.0000000,0.0000000,0.0000000,0.0000,1+32,,measured,0,,0.00000000\n");
  EXPECT_EQ(sink->counters().rows_written, 2u);
  EXPECT_EQ(sink->problem(), "");
}

TEST(TrackSink, JsonlHoldsOneObjectATickAlsoWithoutPoints) {
  ScratchFolder folder;
  const auto sink = make_track_sink(parse_output_spec("jsonl:" + (folder / "t.jsonl")));
  const std::vector<TrackedPoint> points{point(1, {0.1, 2, 3}, 0.5, 0b101), point(2, {1, 1, 1}, 0.25, 0b10)};
  EXPECT_EQ(sink->write({TriggerNo(0), at_ns(0), {}}), SinkStatus::Ok);
  EXPECT_EQ(sink->write({TriggerNo(1), at_ns(11'111'111), points, 0b111, 123.4567e-6, at_ns(11'500'000)}),
            SinkStatus::Ok);
  EXPECT_EQ(sink->finish(), SinkStatus::Ok);
  EXPECT_EQ(text_of(folder / "t.jsonl"),
            "{\"tick\":0,\"time_ns\":0,\"cameras\":[],\"points\":[]}\n"
            "{\"tick\":1,\"time_ns\":11111111,\"time_error_ns\":123457,\"stamped_ns\":11500000,"
            "\"cameras\":[1,2,3],\"points\":["
            "{\"id\":1,\"x_m\":0.1000000,\"y_m\":2.0000000,\"z_m\":3.0000000,\"residual_px\":0.5000,"
            "\"cameras\":[1,3],\"aligned\":null,"
            "\"kind\":\"measured\",\"age\":0,\"ambiguous\":null,\"sd_m\":0.00000000},"
            "{\"id\":2,\"x_m\":1.0000000,\"y_m\":1.0000000,\"z_m\":1.0000000,\"residual_px\":0.2500,"
            "\"cameras\":[2],\"aligned\":null,"
            "\"kind\":\"measured\",\"age\":0,\"ambiguous\":null,\"sd_m\":0.00000000}"
            "]}\n");
}

TEST(TrackSink, SaysOfEachPointWhetherItsCamerasAreProven) {
  ScratchFolder folder;
  const auto csv = make_track_sink(parse_output_spec("csv:" + (folder / "t.csv")));
  const auto jsonl = make_track_sink(parse_output_spec("jsonl:" + (folder / "t.jsonl")));
  const std::vector<TrackedPoint> points{point(1, {0, 0, 0}, 0, 0b0011), point(2, {0, 0, 0}, 0, 0b0110)};
  TrackRow row{TriggerNo(1), at_ns(5), points};
  row.unproven = 0b0100;
  TrackRow dark{TriggerNo(2), at_ns(6), {}};
  dark.unproven = 0b0100;
  dark.dark = true;
  for (TrackSink* const sink : {csv.get(), jsonl.get()}) {
    EXPECT_EQ(sink->write(row), SinkStatus::Ok);
    EXPECT_EQ(sink->write(dark), SinkStatus::Ok);
    EXPECT_EQ(sink->finish(), SinkStatus::Ok);
  }
  EXPECT_THAT(text_of(folder / "t.csv"), testing::HasSubstr(",1+2,1,"));
  EXPECT_THAT(text_of(folder / "t.csv"), testing::HasSubstr(",2+3,0,"));
  const std::string lines = text_of(folder / "t.jsonl");
  EXPECT_THAT(lines, testing::HasSubstr("\"cameras\":[1,2],\"aligned\":true,"));
  EXPECT_THAT(lines, testing::HasSubstr("\"cameras\":[2,3],\"aligned\":false,"));
  EXPECT_THAT(lines, testing::HasSubstr("\"cameras\":[],\"dark\":true,\"points\":[]}\n"));
}

TEST(TrackSink, SaysOfEachPointWhatItRestsOnAndWhetherItIsInDoubt) {
  ScratchFolder folder;
  const auto csv = make_track_sink(parse_output_spec("csv:" + (folder / "t.csv")));
  const auto jsonl = make_track_sink(parse_output_spec("jsonl:" + (folder / "t.jsonl")));
  std::vector<TrackedPoint> points{point(7, {0, 0, 0}, 0.5, 0b1), point(9, {0, 0, 0}, 0, 0)};
  points[0].kind = SampleKind::SingleView;
  points[0].age_frames = 2;
  points[0].ambiguous_with = TrackId(9);
  points[0].covariance_m2.diagonal() << 1e-10, 4e-10, 7e-10;  // mean (2e-5)^2
  points[1].kind = SampleKind::Predicted;
  points[1].age_frames = 11;
  points[1].covariance_m2(0, 0) = std::numeric_limits<double>::infinity();
  const TrackRow row{TriggerNo(1), at_ns(5), points};
  for (TrackSink* const sink : {csv.get(), jsonl.get()}) {
    EXPECT_EQ(sink->write(row), SinkStatus::Ok);
    EXPECT_EQ(sink->finish(), SinkStatus::Ok);
  }
  EXPECT_THAT(text_of(folder / "t.csv"), testing::HasSubstr(",1,,single-view,2,9,0.00002000\n"));
  EXPECT_THAT(text_of(folder / "t.csv"), testing::HasSubstr(",,,predicted,11,,nan\n"));
  EXPECT_THAT(
      text_of(folder / "t.jsonl"),
      testing::HasSubstr(",\"kind\":\"single-view\",\"age\":2,\"ambiguous\":9,\"sd_m\":0.00002000},"));
  EXPECT_THAT(text_of(folder / "t.jsonl"),
              testing::HasSubstr(",\"kind\":\"predicted\",\"age\":11,\"ambiguous\":null,\"sd_m\":null}]}\n"));
}

TEST(TrackSink, JsonTellsWhatBecameOfIdentities) {
  ScratchFolder folder;
  const auto sink = make_track_sink(parse_output_spec("jsonl:" + (folder / "t.jsonl")));
  using Kind = IdentityEvent::Kind;
  const std::vector<IdentityEvent> events{{Kind::Ambiguous, TrackId(7), TrackId(9), {}, {}},
                                          {Kind::Kept, TrackId(1), TrackId(2), {}, {}},
                                          {Kind::Swapped, TrackId(3), TrackId(4), {}, {}},
                                          {Kind::Unresolved, TrackId(5), TrackId(6), TrackId(31), {}}};
  TrackRow row{TriggerNo(1), at_ns(5), {}};
  row.identity = events;
  EXPECT_EQ(sink->write(row), SinkStatus::Ok);
  EXPECT_EQ(sink->finish(), SinkStatus::Ok);
  EXPECT_EQ(text_of(folder / "t.jsonl"),
            "{\"tick\":1,\"time_ns\":5,\"cameras\":[],\"identity\":["
            "{\"kind\":\"ambiguous\",\"a\":7,\"b\":9},"
            "{\"kind\":\"kept\",\"a\":1,\"b\":2},"
            "{\"kind\":\"swapped\",\"a\":3,\"b\":4},"
            "{\"kind\":\"unresolved\",\"a\":5,\"b\":6,\"new_a\":31,\"new_b\":null}"
            "],\"points\":[]}\n");
}

TEST(TrackSink, JsonKnowsNoNan) {
  ScratchFolder folder;
  const auto sink = make_track_sink(parse_output_spec("jsonl:" + (folder / "t.jsonl")));
  const std::vector<TrackedPoint> points{point(1, {std::numeric_limits<double>::quiet_NaN(), 2, 3}, 0.5, 1)};
  EXPECT_EQ(sink->write({TriggerNo(0), at_ns(0), points}), SinkStatus::Ok);
  EXPECT_EQ(sink->finish(), SinkStatus::Ok);
  EXPECT_THAT(text_of(folder / "t.jsonl"), testing::HasSubstr("\"x_m\":null"));
}

TEST(TrackSink, NoneWritesNothing) {
  const auto sink = make_track_sink(parse_output_spec("none"));
  EXPECT_EQ(sink->write({}), SinkStatus::Ok);
  EXPECT_EQ(sink->finish(), SinkStatus::Ok);
  EXPECT_EQ(sink->counters().rows_written, 0u);
}

TEST(TrackSink, ForceIsPassedOn) {
  ScratchFolder folder;
  std::ofstream(folder / "t.csv") << "old";
  EXPECT_THROW(make_track_sink(parse_output_spec("csv:" + (folder / "t.csv"))), Error);
  EXPECT_NO_THROW(make_track_sink(parse_output_spec("csv:" + (folder / "t.csv"), true)));
}

shaders::BlobRecord blob(float x_px, float y_px, float x_undist, float y_undist) {
  shaders::BlobRecord b{};
  b.x_px = x_px;
  b.y_px = y_px;
  b.x_undist = x_undist;
  b.y_undist = y_undist;
  b.area_px = 12;
  b.sum = 2040;
  b.peak = 255;
  return b;
}

std::vector<CameraCalibration> two_cameras() {
  std::vector<CameraCalibration> cameras(2);  // the first has no known lens
  cameras[1].fx_px = 800;
  cameras[1].fy_px = -900;  // as tools with a mirrored axis write it
  cameras[1].cx_px = 640;
  cameras[1].cy_px = 400;
  return cameras;
}

TEST(BlobSink, CsvGivesUndistortedPixels) {
  ScratchFolder folder;
  const auto cameras = two_cameras();
  const auto sink = make_blob_sink(parse_output_spec("csv:" + (folder / "b.csv")), cameras);
  const std::vector<shaders::BlobRecord> first{blob(10.5f, 20.25f, 10.5f, 20.25f)};
  const std::vector<shaders::BlobRecord> second{blob(100, 200, 0.125f, -0.25f)};
  EXPECT_EQ(sink->write({TriggerNo(3), CameraId(0), first, false}), SinkStatus::Ok);
  EXPECT_EQ(sink->write({TriggerNo(3), CameraId(1), second, true}), SinkStatus::Ok);
  EXPECT_EQ(sink->finish(), SinkStatus::Ok);
  EXPECT_EQ(text_of(folder / "b.csv"),
            "tick,camera,x_px,y_px,x_undist_px,y_undist_px,area_px,sum,peak,overflow\n"
            "3,1,10.50000,20.25000,10.50000,20.25000,12,2040,255,0\n"
            "3,2,100.00000,200.00000,740.00000,625.00000,12,2040,255,1\n");
}

TEST(BlobSink, JsonlTellsOfACameraWithoutBlobs) {
  ScratchFolder folder;
  const auto cameras = two_cameras();
  const auto sink = make_blob_sink(parse_output_spec("jsonl:" + (folder / "b.jsonl")), cameras);
  const std::vector<shaders::BlobRecord> blobs{blob(1, 2, 3, 4), blob(5, 6, 7, 8)};
  EXPECT_EQ(sink->write({TriggerNo(0), CameraId(0), blobs, false}), SinkStatus::Ok);
  EXPECT_EQ(sink->write({TriggerNo(0), CameraId(1), {}, true}), SinkStatus::Ok);
  EXPECT_EQ(sink->finish(), SinkStatus::Ok);
  EXPECT_EQ(text_of(folder / "b.jsonl"),
            "{\"tick\":0,\"camera\":1,\"overflow\":false,\"blobs\":["
            "{\"x_px\":1.00000,\"y_px\":2.00000,\"x_undist_px\":3.00000,\"y_undist_px\":4.00000,"
            "\"area_px\":12,\"sum\":2040,\"peak\":255},"
            "{\"x_px\":5.00000,\"y_px\":6.00000,\"x_undist_px\":7.00000,\"y_undist_px\":8.00000,"
            "\"area_px\":12,\"sum\":2040,\"peak\":255}]}\n"
            "{\"tick\":0,\"camera\":2,\"overflow\":true,\"blobs\":[]}\n");
}

TEST(BlobSink, NoneWritesNothing) {
  const auto sink = make_blob_sink(parse_output_spec("none"), {});
  EXPECT_EQ(sink->write({}), SinkStatus::Ok);
  EXPECT_EQ(sink->finish(), SinkStatus::Ok);
}

}  // namespace
}  // namespace glint
