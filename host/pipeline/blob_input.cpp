// SPDX-License-Identifier: MIT
// Blob files to blobs with undistorted coordinates.
#include "host/pipeline/blob_input.hpp"

#include "gpu/lens.hpp"
#include "host/base/check.hpp"

namespace glint {

BlobInput::BlobInput(std::unique_ptr<BlobSource> source, std::span<const gpu::Lens> lenses, double rate_hz,
                     const PaceOptions& pace, std::uint64_t max_sets)
    : source_(std::move(source)),
      lenses_(lenses.begin(), lenses.end()),
      rate_hz_(rate_hz),
      pacer_(pace),
      paced_(pace.pace != Pace::Fastest),
      max_sets_(max_sets) {
  GLINT_CHECK(lenses_.size() == source_->cameras().size());
}

ReadStatus BlobInput::next(TickBlobs& tick) noexcept {
  const std::uint64_t done = sets_.load(std::memory_order_relaxed);
  if (stop_.stop_requested() || (max_sets_ != 0 && done >= max_sets_)) return ReadStatus::End;
  const ReadStatus status = source_->read(set_);
  if (status != ReadStatus::Ok) return status;
  if (paced_) (void)pacer_.wait(pacer_.due(set_), stop_.get_token());
  tick.trigger = set_.trigger;
  tick.exposed = set_.exposed;
  tick.delivered = std::chrono::steady_clock::now();
  tick.live.reset();
  tick.frames = static_cast<std::uint32_t>((std::uint64_t{1} << set_.cameras.size()) - 1);
  tick.has_images = false;
  tick.overflow = 0;
  tick.unproven.reset();
  tick.dark = false;
  tick.events = {};
  tick.stages = {};
  tick.cameras.resize(set_.cameras.size());
  for (std::size_t camera = 0; camera < set_.cameras.size(); ++camera) {
    for (gpu::BlobRecord& blob : set_.cameras[camera]) {
      const gpu::Undistorted u =
          gpu::undistort(lenses_[camera], static_cast<double>(blob.x_px), static_cast<double>(blob.y_px));
      blob.camera = static_cast<std::uint32_t>(camera);
      blob.x_undist = static_cast<float>(u.x);
      blob.y_undist = static_cast<float>(u.y);
      if (!u.converged) blob.flags |= shaders::kBlobNotInvertible;
    }
    tick.cameras[camera] = set_.cameras[camera];
  }
  tick.detected = std::chrono::steady_clock::now();
  sets_.store(done + 1, std::memory_order_relaxed);
  return ReadStatus::Ok;
}

InputCounters BlobInput::counters() const noexcept {
  InputCounters c;
  c.sets = sets_.load(std::memory_order_relaxed);
  return c;
}

}  // namespace glint
