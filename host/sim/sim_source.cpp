// SPDX-License-Identifier: MIT
// Frame sets of the simulated rig, faults applied.
#include "host/sim/sim_source.hpp"

#include <algorithm>
#include <chrono>
#include <cstring>
#include <exception>

#include "host/sim/faults.hpp"
#include "host/sim/random.hpp"

namespace glint {
namespace {

constexpr std::size_t kBuffersPerCamera = 64;  // more pools and slots than that are met only in tests

Timestamp after(Timestamp start, double seconds) noexcept {
  return start + std::chrono::duration_cast<Timestamp::duration>(std::chrono::duration<double>(seconds));
}

std::uint64_t moved(std::uint64_t tick, int by) noexcept {
  const auto back = static_cast<std::uint64_t>(by < 0 ? -by : 0);
  return by < 0 ? tick - std::min(tick, back) : tick + static_cast<std::uint64_t>(by);
}

}  // namespace

SimSource::SimSource(const Scene& scene, const SimSourceOptions& options)
    : scene_(scene), options_(options), renderer_(scene), buffers_(scene.cameras()) {
  const SimOptions& sim = scene.options();
  for (const CameraCalibration& camera : scene.calibration().cameras) {
    cameras_.push_back({camera.name, {camera.width_px, camera.height_px}});
  }
  for (std::vector<Buffer>& buffers : buffers_) buffers.reserve(kBuffersPerCamera);
  if (sim.jpeg_quality > 0) {
    jpeg_ = std::make_unique<sim::JpegRoundTrip>(sim.width_px, sim.height_px, sim.jpeg_quality);
  }
}

ReadStatus SimSource::read(FramePool& pool, FrameSet& set) noexcept {
  for (std::optional<Frame>& frame : set.frames) frame.reset();
  if (options_.ticks > 0 && next_tick_ >= options_.ticks) return ReadStatus::End;
  const SimOptions& sim = scene_.options();
  const std::uint64_t tick = next_tick_++;
  set.trigger = TriggerNo{tick};
  set.exposed = after(start_, static_cast<double>(tick) / sim.rate_hz);
  try {
    for (std::uint32_t c = 0; c < sim.cameras; ++c) {
      const sim::Fate fate = sim::fate(sim, c, tick);
      if (fate == sim::Fate::Dropped || fate == sim::Fate::Late) {
        ++counters_.missing;
        if (fate == sim::Fate::Late) ++counters_.late;
        continue;
      }
      std::optional<Frame> frame = pool.take(CameraId{static_cast<std::uint8_t>(c)});
      if (!frame) {
        ++counters_.no_slot;
        continue;
      }
      const int shift = wanted_shift_[c].load(std::memory_order_relaxed);
      // Nobody stamps the copy anew: a stuck driver buffer carries everything of the old frame.
      const std::uint64_t wanted = fate == sim::Fate::Duplicated ? tick - 1 : tick;
      const std::uint64_t number = moved(wanted, -shift);
      if (!draw(c, shown(c, number), *frame)) return ReadStatus::Failed;
      const bool slips = sim.faults.slip && sim.faults.slip->camera == c && sim.faults.slip->tick == number;
      if (fate == sim::Fate::Duplicated || slips) ++run_[c];
      frame->run = run_[c];
      frame->shifted = shift;
      frame->sequence = static_cast<std::uint32_t>(number);
      frame->stamp = StampPoint::StartOfExposure;
      frame->stamped = after(start_, static_cast<double>(number) / sim.rate_hz - 0.5 * sim.exposure_s);
      frame->damaged = false;
      if (fate == sim::Fate::Duplicated) ++counters_.duplicated;
      ++counters_.frames;
      set.frames[c] = std::move(frame);
    }
  } catch (const std::exception& error) {
    problem_ = std::string("simulated rig: ") + error.what();
    return ReadStatus::Failed;
  }
  set.delivered = std::chrono::steady_clock::now();
  return ReadStatus::Ok;
}

/// The exposure that a frame shows.
std::uint64_t SimSource::shown(std::uint32_t camera, std::uint64_t frame) const noexcept {
  const std::optional<SimSlip>& slip = scene_.options().faults.slip;
  return slip && slip->camera == camera && frame >= slip->tick ? moved(frame, -slip->pulses) : frame;
}

SimSource::Buffer& SimSource::buffer_at(std::uint32_t camera, const std::uint8_t* pixels) {
  std::vector<Buffer>& known = buffers_[camera];
  const auto found =
      std::find_if(known.begin(), known.end(), [&](const Buffer& b) { return b.pixels == pixels; });
  if (found != known.end()) return *found;
  if (known.size() >= kBuffersPerCamera) known.erase(known.begin());  // of a pool that is long gone
  Buffer& fresh = known.emplace_back();
  fresh.pixels = pixels;
  fresh.memory.drawn.reserve(scene_.markers());
  return fresh;
}

std::uint64_t SimSource::fingerprint(std::span<const std::uint8_t> pixels) const noexcept {
  constexpr std::size_t kProbes = 32;
  std::uint64_t hash = 0;
  for (std::size_t i = 0; i < kProbes; ++i) {
    std::uint64_t word = 0;
    std::memcpy(&word, pixels.data() + (pixels.size() - sizeof word) / kProbes * i, sizeof word);
    hash = sim::mix(hash ^ word);
  }
  return hash;
}

bool SimSource::draw(std::uint32_t camera, std::uint64_t tick, Frame& frame) {
  const std::span<std::uint8_t> pixels = frame.pixels();
  Buffer& buffer = buffer_at(camera, pixels.data());
  // A new pool may lie where an old one was.
  if (buffer.fingerprint != fingerprint(pixels)) {
    buffer.memory.stripe.fill(sim::BufferMemory::kUnknown);
    buffer.memory.drawn.clear();
  }
  renderer_.render(camera, tick, pixels.data(), frame.stride_bytes(), buffer.memory);
  if (jpeg_ && !jpeg_->apply(pixels.data(), frame.stride_bytes())) {
    problem_ = "simulated rig: libjpeg-turbo cannot compress a frame at quality " +
               std::to_string(scene_.options().jpeg_quality);
    return false;
  }
  if (jpeg_) buffer.memory.stripe.fill(sim::BufferMemory::kUnknown);  // the whole image was touched
  buffer.fingerprint = fingerprint(pixels);
  return true;
}

}  // namespace glint
