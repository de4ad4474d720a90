// SPDX-License-Identifier: MIT
// Feeds the assembler as the source would, and the pipeline as the detector would.
#include "tests/unit/pipeline/coded_rig.hpp"

#include <cstring>
#include <numbers>

#include "gpu/lens.hpp"
#include "host/pipeline/coded_light.hpp"

namespace glint::testing {
namespace {

constexpr double kCentroidNoise_px = 0.05;
constexpr int kSetsInFlight = 3;
constexpr std::size_t kTruths = 32;

RigOptions of_scene(const CodedRigOptions& options) {
  RigOptions rig = options.rig;
  rig.cameras = options.scene.cameras;
  rig.rate_hz = options.scene.rate_hz;
  return rig;
}

AssembleOptions assemble_options(const SimOptions& scene) {
  AssembleOptions options;
  options.rate_hz = scene.rate_hz;
  options.most_sets_waiting += CodeAlignment::kMostSlip;
  return options;
}

PulseCode code_of(const SimOptions& scene) {
  return {scene.code_seed,
          scene.code_group != 0 ? scene.code_group : PulseCode::recommended_group(scene.rate_hz)};
}

}  // namespace

CodedRig::CodedRig(const CodedRigOptions& options, const Scene& scene)
    : options_(options),
      scene_(scene),
      rig_(of_scene(options)),
      pool_(std::vector<FrameSize>(options.scene.cameras, FrameSize{16, 8}), 64),
      assembler_(options.scene.cameras, assemble_options(options.scene)),
      alignment_(code_of(options.scene), options.scene.cameras),
      blobs_(options.scene.cameras),
      shown_(static_cast<std::size_t>(options.rig.pulses)),
      truths_(kTruths),
      random_(options.rig.seed) {
  for (const CameraCalibration& camera : scene.calibration().cameras) described_.push_back({camera.name, {}});
}

void CodedRig::deliver(const Delivery& delivery) {
  clock_s_ = delivery.arrived_s;
  const CameraId camera{static_cast<std::uint8_t>(delivery.camera)};
  if (delivery.left) {
    assembler_.set_present(camera, false);
    return;
  }
  std::optional<Frame> frame = pool_.take(camera);
  if (!frame) return;
  std::memcpy(frame->pixels().data(), &delivery.shown, sizeof delivery.shown);
  frame->sequence = delivery.sequence;
  frame->stamped = at(delivery.stamped_s);
  frame->stamp = StampPoint::StartOfExposure;
  frame->damaged = delivery.damaged;
  assembler_.add(std::move(*frame), at(delivery.arrived_s));
}

bool CodedRig::next_set() {
  while (!assembler_.next(set_, at(clock_s_))) {
    if (delivered_ == rig_.deliveries.size()) return false;
    const std::optional<Timestamp> due = assembler_.due();
    const double next_s = rig_.deliveries[delivered_].arrived_s;
    if (due && *due > at(clock_s_) && *due < at(next_s)) {
      clock_s_ = std::chrono::duration<double>(due->time_since_epoch()).count() + 1e-6;
      continue;
    }
    deliver(rig_.deliveries[delivered_++]);
  }
  return true;
}

const TickTruth& CodedRig::truth(std::int64_t exposure) {
  std::optional<TickTruth>& kept = truths_[static_cast<std::size_t>(exposure) % kTruths];
  if (!kept) kept.emplace().tick = ~std::uint64_t{0};
  if (kept->tick != static_cast<std::uint64_t>(exposure)) {
    scene_.truth(static_cast<std::uint64_t>(exposure), *kept);
  }
  return *kept;
}

void CodedRig::make_blobs(std::uint32_t camera, std::int64_t exposure, std::vector<gpu::BlobRecord>& blobs) {
  blobs.clear();
  for (const CodedRigOptions::Blackout& blackout : options_.blackouts) {
    if (blackout.camera == camera && exposure >= blackout.from && exposure < blackout.to) return;
  }
  const TickTruth& truth = this->truth(exposure);
  const CameraCalibration& c = scene_.calibration().cameras[camera];
  const gpu::Lens lens{c.fx_px, c.fy_px, c.cx_px, c.cy_px, c.k1_k2_p1_p2_k3};
  std::normal_distribution<double> noise(0.0, kCentroidNoise_px);
  for (std::size_t m = 0; m < truth.markers.size(); ++m) {
    if ((truth.markers[m].visible >> camera & 1U) == 0) continue;
    const sim::MarkerView& view = truth.views_of(camera)[m];
    gpu::BlobRecord blob{};
    blob.camera = camera;
    const double x = view.x_px + noise(random_), y = view.y_px + noise(random_);
    const gpu::Undistorted u = gpu::undistort(lens, x, y);
    blob.x_px = static_cast<float>(x);
    blob.y_px = static_cast<float>(y);
    blob.x_undist = static_cast<float>(u.x);
    blob.y_undist = static_cast<float>(u.y);
    const double area = std::numbers::pi * view.half_width_px * view.half_height_px;
    blob.area_px = static_cast<std::uint32_t>(area + 0.5);
    blob.peak = 150;
    blob.sum = blob.weight = 100 * blob.area_px;
    blob.x_min_px = static_cast<std::uint32_t>(x - view.half_width_px);
    blob.x_max_px = static_cast<std::uint32_t>(x + view.half_width_px);
    blob.y_min_px = static_cast<std::uint32_t>(y - view.half_height_px);
    blob.y_max_px = static_cast<std::uint32_t>(y + view.half_height_px);
    blob.var_xx_px2 = static_cast<float>(0.25 * view.half_width_px * view.half_width_px);
    blob.var_yy_px2 = static_cast<float>(0.25 * view.half_height_px * view.half_height_px);
    blobs.push_back(blob);
  }
}

void CodedRig::shift_when_due() {
  if (!request_ || request_->sets_left-- > 0) return;
  const std::size_t camera = index(request_->camera);
  assembler_.shift(request_->camera, request_->pulses - shifted_[camera]);
  shifted_[camera] = request_->pulses;
  request_.reset();
}

ReadStatus CodedRig::next(TickBlobs& tick) noexcept {
  if (!next_set()) return ReadStatus::End;
  shift_when_due();
  tick.trigger = set_.trigger;
  tick.exposed = set_.exposed;
  tick.delivered = tick.detected = std::chrono::steady_clock::now();
  tick.frames = 0;
  tick.cameras.resize(blobs_.size());
  ShownExposures& shown = shown_.at(number(set_.trigger));
  shown.fill(-1);
  for (std::uint32_t c = 0; c < blobs_.size(); ++c) {
    blobs_[c].clear();
    if (set_.frames[c]) {
      std::memcpy(&shown[c], set_.frames[c]->pixels().data(), sizeof shown[c]);
      make_blobs(c, shown[c], blobs_[c]);
      tick.frames |= 1U << c;
    }
    tick.cameras[c] = blobs_[c];
  }
  check_light(alignment_, set_, tick);
  for (const AlignmentEvent& event : tick.events) {
    if (event.kind == AlignmentEvent::Kind::SlipFound)
      request_ = Request{event.camera, alignment_.wanted_shift(event.camera), kSetsInFlight};
  }
  return ReadStatus::Ok;
}

}  // namespace glint::testing
