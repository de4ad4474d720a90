// SPDX-License-Identifier: MIT
// The same pieces as `glint track sim`, without its clock.
#include "benchmarks/identity/product.hpp"

#include "host/base/error.hpp"
#include "host/config/rig.hpp"
#include "host/pipeline/frame_input.hpp"
#include "host/pipeline/learn_background.hpp"
#include "host/sim/calibration_error.hpp"
#include "host/sim/sim_source.hpp"

namespace glint::identity {
namespace {

MatchOptions match_options(double marker_radius_m) {
  MatchOptions match;
  match.marker_radius_m = marker_radius_m;
  match.exposure_s = SimOptions{}.exposure_s;
  return match;
}

// Known to a hundredth of a millimetre, as those of `glint track sim`.
std::vector<BodyModel> bodies_of(const Scene& scene) {
  std::vector<BodyModel> bodies;
  for (std::uint32_t b = 0; b < scene.bodies(); ++b)
    bodies.push_back({"body" + std::to_string(b + 1), scene.body_markers(b), 1e-5});
  return bodies;
}

}  // namespace

Calibration given_calibration(const Scene& scene, double calibration_error_px) {
  return disturbed(scene.calibration(), calibration_error_px, scene.options().seed);
}

std::unique_ptr<TickInput> open_scene(const Scene& scene, std::uint64_t ticks) {
  const DetectSettings detect;
  std::vector<gpu::Lens> lenses;
  for (const CameraCalibration& c : scene.calibration().cameras)
    lenses.push_back({c.fx_px, c.fy_px, c.cx_px, c.cy_px, c.k1_k2_p1_p2_k3});
  FrameInputOptions options;
  options.device = "cpu";
  options.detector.min_area_px = detect.min_area_px;
  options.detector.max_area_px = detect.max_area_px;
  options.detector.max_blobs_per_camera = detect.max_blobs_per_camera;
  options.detector.threads = 1;
  options.pace = {Pace::Fastest, 0.0};
  auto input = std::make_unique<FrameInput>(
      std::make_unique<SimSource>(scene, SimSourceOptions{false, ticks}), lenses, options);
  // Of the empty room: a marker that rests while the background is learnt becomes a part of it.
  SimOptions empty = scene.options();
  empty.motion = SimMotion::Thrown;
  empty.wand_m.clear();
  empty.person = false;
  empty.markers = 0;
  const Scene room(empty);
  SimSource lesson(room, {false, 0});
  const LearntBackgrounds learnt = learn_backgrounds(lesson, detect.background_frames, detect.threshold);
  for (std::uint32_t c = 0; c < scene.cameras(); ++c) input->set_background(c, learnt.cameras[c]);
  return input;
}

ReadStatus TappedInput::next(TickBlobs& tick) noexcept {
  const ReadStatus status = input_->next(tick);
  if (status == ReadStatus::Ok) tap_(tick);
  return status;
}

void to_samples(std::span<const TrackedPoint> points, std::vector<IdentitySample>& samples) {
  samples.clear();
  for (const TrackedPoint& point : points) {
    IdentitySample sample;
    sample.id = number(point.id);
    sample.position_in_world = point.position_in_world;
    sample.covariance_m2 = point.covariance_m2;
    sample.cameras = point.cameras;
    sample.predicted = point.kind != SampleKind::Measured;
    sample.ambiguous = point.ambiguous_with != TrackId{};
    samples.push_back(sample);
  }
}

BodiesKnown::BodiesKnown(const Scene& scene, const Calibration& calibration)
    : step_(calibration, match_options(scene.options().marker_radius_m), {}, bodies_of(scene)),
      of_markers_(scene),
      of_poses_(scene) {}

void BodiesKnown::take(const TickBlobs& tick) {
  step_.take(tick);
  to_samples(step_.tracked(), samples_);
  of_markers_.add(number(tick.trigger), samples_);
  scored_.clear();
  for (const TrackedBody& body : step_.bodies())
    scored_.push_back({body.body, body.world_from_body, body.kind == BodyKind::Measured, body.ambiguous});
  of_poses_.add(number(tick.trigger), scored_);
}

void track(std::unique_ptr<TickInput> input, const Calibration& calibration, double marker_radius_m,
           const std::function<void(std::uint64_t tick, std::span<const IdentitySample>)>& take) {
  TrackPipeline pipeline(std::move(input), calibration, match_options(marker_radius_m), {});
  std::vector<IdentitySample> samples;
  const ReadStatus end = pipeline.run([&](const TickResult& tick) {
    to_samples(tick.points, samples);
    take(number(tick.trigger), samples);
  });
  if (end == ReadStatus::Failed) throw Error(pipeline.problem());
}

}  // namespace glint::identity
