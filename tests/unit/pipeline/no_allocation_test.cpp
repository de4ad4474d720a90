// SPDX-License-Identifier: MIT
// From frames to points, all threads together, nothing is allocated once the run is warm.
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "host/pipeline/frame_input.hpp"
#include "host/pipeline/learn_background.hpp"
#include "host/pipeline/track_pipeline.hpp"
#include "host/sim/frame_loop.hpp"
#include "host/sim/rig.hpp"
#include "host/sim/sim_source.hpp"
#include "tests/support/allocations.hpp"

namespace glint {
namespace {

TEST(PipelineNoAllocation, OnceWarm) {
  SimOptions options;
  options.width_px = 640;
  options.height_px = 400;
  options.markers = 8;
  const Scene scene(options);
  const Calibration rig = sim_calibration(options);
  std::vector<gpu::Lens> lenses;
  for (const CameraCalibration& c : rig.cameras)
    lenses.push_back({c.fx_px, c.fy_px, c.cx_px, c.cy_px, c.k1_k2_p1_p2_k3});
  FrameInputOptions input_options;
  input_options.device = "cpu";
  input_options.pace = {Pace::Fastest, 0.0};
  constexpr std::uint64_t kLength = 20, kWarm = 200, kTicks = 500;
  auto input = std::make_unique<FrameInput>(std::make_unique<FrameLoop>(scene, kLength, kTicks, false),
                                            lenses, input_options);
  SimSource to_learn_from(scene);
  const LearntBackgrounds learnt = learn_backgrounds(to_learn_from, 10, 12);
  for (std::uint32_t i = 0; i < learnt.cameras.size(); ++i) input->set_background(i, learnt.cameras[i]);
  TrackPipeline pipeline(std::move(input), rig, {}, {});

  std::uint64_t seen = 0;
  std::size_t when_warm = 0, at_end = 0, points = 0;
  ASSERT_NE(pipeline.run([&](const TickResult& tick) {
    if (++seen == kWarm) when_warm = testing::allocations();
    if (seen == kTicks - 10) at_end = testing::allocations();  // before anybody says good-bye
    points += tick.points.size();
  }),
            ReadStatus::Failed)
      << pipeline.problem();
  EXPECT_EQ(seen, kTicks);
  EXPECT_GT(points, 6 * kTicks) << "little was tracked: the test shows nothing";
  ASSERT_GT(when_warm, 0u);
  EXPECT_EQ(at_end - when_warm, 0u);
}

}  // namespace
}  // namespace glint
