// SPDX-License-Identifier: MIT
// Rendered once, copied every tick.
#include "host/sim/frame_loop.hpp"

#include <algorithm>
#include <chrono>

#include "host/sim/renderer.hpp"
#include "host/sim/rig.hpp"

namespace glint {

FrameLoop::FrameLoop(const Scene& scene, std::uint64_t length, std::uint64_t ticks, bool live)
    : rate_hz_(scene.options().rate_hz), length_(length), ticks_(ticks), live_(live) {
  const SimOptions& options = scene.options();
  const std::size_t frame_bytes = std::size_t{options.width_px} * options.height_px;
  for (const CameraCalibration& camera : sim_calibration(options).cameras)
    cameras_.push_back({camera.name, {options.width_px, options.height_px}});
  pixels_.resize(length * cameras_.size() * frame_bytes);
  sim::Renderer renderer(scene);
  std::uint8_t* to = pixels_.data();
  for (std::uint64_t tick = 0; tick < length; ++tick) {
    for (std::uint32_t camera = 0; camera < cameras_.size(); ++camera, to += frame_bytes) {
      sim::BufferMemory fresh;
      renderer.render(camera, tick, to, options.width_px, fresh);
    }
  }
}

ReadStatus FrameLoop::read(FramePool& pool, FrameSet& set) noexcept {
  for (auto& frame : set.frames) frame.reset();
  if (next_ == ticks_) return ReadStatus::End;
  const std::uint64_t turn = length_ > 1 ? next_ % (2 * length_ - 2) : 0;
  const std::uint64_t tick = turn < length_ ? turn : 2 * length_ - 2 - turn;
  set.trigger = TriggerNo(next_);
  set.exposed = Timestamp(std::chrono::duration_cast<Timestamp::duration>(
      std::chrono::duration<double>(static_cast<double>(next_) / rate_hz_)));
  for (std::uint32_t camera = 0; camera < cameras_.size(); ++camera) {
    std::optional<Frame> frame = pool.take(CameraId(camera));
    if (!frame) {
      ++counters_.no_slot;
      continue;
    }
    const auto [width_px, height_px] = cameras_[camera].size;
    const std::uint8_t* from =
        pixels_.data() + (tick * cameras_.size() + camera) * std::size_t{width_px} * height_px;
    std::uint8_t* to = frame->pixels().data();
    for (std::uint32_t y = 0; y < height_px; ++y, from += width_px, to += frame->stride_bytes())
      std::copy_n(from, width_px, to);
    frame->camera = CameraId(camera);
    frame->sequence = static_cast<std::uint32_t>(next_);
    set.frames[camera] = std::move(frame);
    ++counters_.frames;
  }
  ++next_;
  return ReadStatus::Ok;
}

}  // namespace glint
