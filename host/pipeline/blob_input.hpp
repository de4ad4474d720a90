// SPDX-License-Identifier: MIT
// Blobs from a file: no images, no detector; the lens model is applied here.
#pragma once

#include <atomic>
#include <memory>

#include "host/capture/pacer.hpp"
#include "host/pipeline/tick_input.hpp"

namespace glint {

class BlobInput final : public TickInput {
 public:
  /// lenses: one per camera of the source. max_sets 0: to the end.
  BlobInput(std::unique_ptr<BlobSource> source, std::span<const gpu::Lens> lenses, double rate_hz,
            const PaceOptions& pace, std::uint64_t max_sets);

  std::span<const SourceCamera> cameras() const noexcept override { return source_->cameras(); }
  bool live() const noexcept override { return false; }
  double rate_hz() const noexcept override { return rate_hz_; }
  const std::string& device_name() const noexcept override { return device_name_; }
  [[nodiscard]] ReadStatus next(TickBlobs& tick) noexcept override;
  void stop() noexcept override { stop_.request_stop(); }
  InputCounters counters() const noexcept override;
  std::string problem() const override { return source_->problem(); }

 private:
  std::unique_ptr<BlobSource> source_;
  std::vector<gpu::Lens> lenses_;
  double rate_hz_;
  Pacer pacer_;
  bool paced_;
  std::uint64_t max_sets_;
  std::string device_name_ = "none (blobs from files)";
  BlobSet set_;
  std::stop_source stop_;
  std::atomic<std::uint64_t> sets_{0};
};

}  // namespace glint
