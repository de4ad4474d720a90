// SPDX-License-Identifier: MIT
// Poses as rows of CSV and as objects in lines of JSON.
#include "host/output/body_sink.hpp"

#include <chrono>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/output/track_sink.hpp"
#include "tests/unit/output/scratch_folder.hpp"

namespace glint {
namespace {

using test::ScratchFolder;
using test::text_of;
using ::testing::HasSubstr;
using ::testing::Not;

std::vector<BodyModel> models() { return {{"drone, red", {}, 1e-4}, {"cart \"2\"", {}, 1e-4}}; }

TrackedBody turned_body() {
  TrackedBody body;
  body.body = 1;
  body.world_from_body.translation = {0.5, -1.25, 0.125};
  body.world_from_body.rotation = Eigen::Quaterniond(-0.5, -0.5, 0.5, -0.5);  // its other sign is written
  body.markers = 4;
  body.views = 12;
  body.rms_px = 0.25;
  body.covariance.diagonal() << 1e-6, 1e-6, 1e-6, 4e-8, 4e-8, 4e-8;
  return body;
}

TEST(BodySink, WritesOneRowABody) {
  const ScratchFolder folder;
  BodySink sink(folder / "b.csv", false, models());
  TrackedBody predicted = turned_body();
  predicted.body = 0;
  predicted.kind = BodyKind::Predicted;
  predicted.age_frames = 3;
  predicted.markers = 1;
  predicted.ambiguous = true;
  predicted.ambiguous_with = 1;
  const Timestamp at = Timestamp(std::chrono::nanoseconds(1'234'567));
  EXPECT_EQ(sink.write(TriggerNo(7), at, std::vector{predicted, turned_body()}), SinkStatus::Ok);
  EXPECT_EQ(sink.write(TriggerNo(8), at, {}), SinkStatus::Ok);
  EXPECT_EQ(sink.finish(), SinkStatus::Ok);
  EXPECT_EQ(
      text_of(folder / "b.csv"),
      "tick,time_ns,body,x_m,y_m,z_m,qx,qy,qz,qw,kind,age,markers,ambiguous,sd_m,sd_rad\n"
      "7,1234567,\"drone, red\",0.5000000,-1.2500000,0.1250000,0.50000000,-0.50000000,0.50000000,0.50000000,"
      "predicted,3,1,\"cart \"\"2\"\"\",0.00020000,0.00100000\n"
      "7,1234567,\"cart "
      "\"\"2\"\"\",0.5000000,-1.2500000,0.1250000,0.50000000,-0.50000000,0.50000000,0.50000000,"
      "measured,0,4,,0.00020000,0.00100000\n");
}

TEST(TrackSink, JsonHasBodiesIfAnyAreLookedFor) {
  const ScratchFolder folder;
  const auto with = make_track_sink(parse_output_spec("jsonl:" + (folder / "w.jsonl")), models());
  const auto without = make_track_sink(parse_output_spec("jsonl:" + (folder / "wo.jsonl")));
  const std::vector<TrackedBody> bodies{turned_body()};
  for (TrackSink* const sink : {with.get(), without.get()}) {
    TrackRow row;
    EXPECT_EQ(sink->write(row), SinkStatus::Ok);
    row.bodies = bodies;
    EXPECT_EQ(sink->write(row), SinkStatus::Ok);
    EXPECT_EQ(sink->finish(), SinkStatus::Ok);
  }
  const std::string text = text_of(folder / "w.jsonl");
  EXPECT_THAT(text, HasSubstr("\"points\":[],\"bodies\":[]}\n"));
  EXPECT_THAT(text,
              HasSubstr("\"bodies\":[{\"name\":\"cart \\\"2\\\"\",\"x_m\":0.5000000,\"y_m\":-1.2500000,"));
  EXPECT_THAT(
      text, HasSubstr("\"qw\":0.50000000,\"kind\":\"measured\",\"age\":0,\"markers\":4,"
                      "\"rms_px\":0.2500,\"ambiguous\":null,\"sd_m\":0.00020000,\"sd_rad\":0.00100000}]}\n"));
  EXPECT_THAT(text_of(folder / "wo.jsonl"), Not(HasSubstr("bodies")));
}

}  // namespace
}  // namespace glint
