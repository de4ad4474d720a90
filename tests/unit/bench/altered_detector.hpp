// SPDX-License-Identifier: MIT
// The reference detector with its results changed on the way out: a driver with an error.
#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "gpu/detector.hpp"

namespace glint::bench::test {

class AlteredDetector final : public gpu::Detector {
 public:
  /// Called with the number of the tick, from 0, and the blobs of all cameras.
  using Change = std::function<void(unsigned, std::vector<std::vector<gpu::BlobRecord>>&)>;

  AlteredDetector(const std::vector<gpu::CameraFormat>& cameras, Change change, unsigned depth = 2)
      : reference_(gpu::make_reference_detector(cameras, with_depth(depth))), change_(std::move(change)) {}

  void break_after(unsigned ticks) noexcept { break_after_ = ticks; }

  const std::string& device_name() const noexcept override { return name_; }
  void set_limit(std::uint32_t camera, std::span<const std::uint8_t> limit) override {
    reference_->set_limit(camera, limit);
  }
  bool adopt_frame_memory(std::span<std::byte>) override { return false; }
  void upload(std::uint32_t, const gpu::ImageView&) noexcept override {}
  gpu::RunStatus submit(std::span<const gpu::ImageView> images) noexcept override {
    return reference_->submit(images);
  }
  gpu::RunStatus collect(gpu::BlobBatch& batch) noexcept override {
    if (tick_ >= break_after_) return gpu::RunStatus::DeviceLost;
    if (const gpu::RunStatus status = reference_->collect(batch); status != gpu::RunStatus::Ok) return status;
    blobs_.clear();
    for (const gpu::CameraBlobs& camera : batch.cameras)
      blobs_.emplace_back(camera.blobs.begin(), camera.blobs.end());
    if (change_) change_(tick_, blobs_);
    for (std::size_t i = 0; i < blobs_.size(); ++i)
      batch.cameras[i] = {blobs_[i], static_cast<std::uint32_t>(blobs_[i].size()), false};
    ++tick_;
    return gpu::RunStatus::Ok;
  }
  const std::string& last_error() const noexcept override { return problem_; }

 private:
  static gpu::DetectorOptions with_depth(unsigned depth) {
    gpu::DetectorOptions options;
    options.depth = depth;
    return options;
  }

  std::unique_ptr<gpu::Detector> reference_;
  Change change_;
  unsigned tick_ = 0, break_after_ = std::numeric_limits<unsigned>::max();
  std::vector<std::vector<gpu::BlobRecord>> blobs_;
  std::string name_ = "altered", problem_ = "gone";
};

}  // namespace glint::bench::test
