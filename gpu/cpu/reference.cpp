// SPDX-License-Identifier: MIT
// The definition of correct: plain loops and a flood fill, one step after the other.
#include <algorithm>
#include <chrono>
#include <new>

#include "gpu/cpu/blob_moments.hpp"
#include "gpu/cpu/set_up.hpp"
#include "gpu/detector.hpp"

namespace glint::gpu {
namespace {

/// Bright: value > limit.
void threshold(const ImageView& image, std::span<const std::uint8_t> limit,
               std::vector<std::uint8_t>& bright) {
  const std::size_t width = image.width_px, height = image.height_px;
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x) {
      bright[y * width + x] = image.pixels[y * image.stride_bytes + x] > limit[y * width + x] ? 1 : 0;
    }
  }
}

/// Adds one pixel to the sums.
void add_pixel(BlobMoments& m, std::uint32_t x, std::uint32_t y, std::uint64_t value, std::uint64_t limit) {
  const std::uint64_t w = value - limit, x64 = x, y64 = y;
  m.area += 1;
  m.peak = std::max(m.peak, static_cast<std::uint32_t>(value));
  m.x_min = std::min(m.x_min, x);
  m.y_min = std::min(m.y_min, y);
  m.x_max = std::max(m.x_max, x);
  m.y_max = std::max(m.y_max, y);
  m.sum += value;
  m.w += w;
  m.wx += w * x64;
  m.wy += w * y64;
  m.wxx += w * x64 * x64;
  m.wxy += w * x64 * y64;
  m.wyy += w * y64 * y64;
}

/// All 8-connected components of `bright`, which is cleared on the way.
void label(const ImageView& image, std::span<const std::uint8_t> limit, std::vector<std::uint8_t>& bright,
           std::vector<std::uint32_t>& stack, std::vector<BlobMoments>& blobs) {
  const std::uint32_t width = image.width_px, height = image.height_px;
  stack.clear();
  for (std::uint32_t first = 0; first < width * height; ++first) {
    if (!bright[first]) continue;
    BlobMoments m;
    m.x_min = m.x_max = first % width;
    m.y_min = m.y_max = first / width;
    bright[first] = 0;
    stack.push_back(first);
    while (!stack.empty()) {
      const std::uint32_t at = stack.back();
      stack.pop_back();
      const std::uint32_t x = at % width, y = at / width;
      add_pixel(m, x, y, image.pixels[std::size_t{y} * image.stride_bytes + x], limit[at]);
      for (std::uint32_t ny = y == 0 ? 0 : y - 1; ny <= std::min(y + 1, height - 1); ++ny) {
        for (std::uint32_t nx = x == 0 ? 0 : x - 1; nx <= std::min(x + 1, width - 1); ++nx) {
          const std::uint32_t neighbour = ny * width + nx;
          if (!bright[neighbour]) continue;
          bright[neighbour] = 0;
          stack.push_back(neighbour);
        }
      }
    }
    blobs.push_back(m);
  }
}

class ReferenceDetector final : public Detector {
 public:
  ReferenceDetector(std::span<const CameraFormat> cameras, const DetectorOptions& options)
      : cameras_(cameras.begin(), cameras.end()), options_(options), sets_(options.depth + 1) {
    problem_.reserve(kProblemBytes);
    for (const CameraFormat& camera : cameras_) {
      limits_.emplace_back(std::size_t{camera.width_px} * camera.height_px, std::uint8_t{255});
    }
  }

  const std::string& device_name() const noexcept override { return name_; }

  void set_limit(std::uint32_t camera, std::span<const std::uint8_t> limit) override {
    check_limit(cameras_, camera, limit.size(), in_flight_);
    limits_[camera].assign(limit.begin(), limit.end());
  }

  bool adopt_frame_memory(std::span<std::byte>) override { return true; }
  void upload(std::uint32_t, const ImageView&) noexcept override {}

  RunStatus submit(std::span<const ImageView> images) noexcept override {
    if (in_flight_ == options_.depth) return RunStatus::Busy;
    if (const RunStatus status = check_images(cameras_, images, problem_); status != RunStatus::Ok)
      return status;
    try {
      detect(images, sets_[(oldest_ + in_flight_) % sets_.size()]);
    } catch (const std::bad_alloc&) {
      problem_.assign("not enough memory for the blobs of this image");
      return RunStatus::DeviceLost;
    }
    ++in_flight_;
    return RunStatus::Ok;
  }

  RunStatus collect(BlobBatch& batch) noexcept override {
    if (in_flight_ == 0) return RunStatus::Idle;
    const Set& set = sets_[oldest_];
    oldest_ = (oldest_ + 1) % sets_.size();
    --in_flight_;
    batch.cameras.resize(cameras_.size());
    for (std::size_t i = 0; i < cameras_.size(); ++i) {
      const Camera& camera = set.cameras[i];
      batch.cameras[i] = {camera.records, camera.found, camera.found > camera.records.size()};
    }
    batch.stages.assign(1, {"detect", set.seconds});
    return RunStatus::Ok;
  }

  const std::string& last_error() const noexcept override { return problem_; }

 private:
  struct Camera {
    std::vector<BlobRecord> records;
    std::uint32_t found = 0;
  };
  struct Set {
    std::vector<Camera> cameras;
    double seconds = 0.0;
  };

  void detect(std::span<const ImageView> images, Set& set) {
    const auto start = std::chrono::steady_clock::now();
    set.cameras.resize(cameras_.size());
    for (std::uint32_t i = 0; i < cameras_.size(); ++i) {
      Camera& camera = set.cameras[i];
      camera.records.clear();
      camera.found = 0;
      if (images[i].pixels == nullptr) continue;
      std::vector<BlobMoments> blobs;
      bright_.resize(limits_[i].size());
      threshold(images[i], limits_[i], bright_);
      label(images[i], limits_[i], bright_, stack_, blobs);
      std::erase_if(blobs, [this](const BlobMoments& m) {
        return m.area < options_.min_area_px || m.area > options_.max_area_px;
      });
      std::sort(blobs.begin(), blobs.end(), before);
      camera.found = static_cast<std::uint32_t>(blobs.size());
      if (blobs.size() > options_.max_blobs_per_camera) blobs.resize(options_.max_blobs_per_camera);
      for (const BlobMoments& m : blobs) {
        const BlobShape s = shape_of(m);
        const Undistorted u =
            undistort_blob(cameras_[i].lens, s.x_px, s.y_px, s.var_xx_px2, s.var_xy_px2, s.var_yy_px2);
        camera.records.push_back(to_record(m, s, u, i, cameras_[i]));
      }
    }
    set.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }

  std::vector<CameraFormat> cameras_;
  DetectorOptions options_;
  std::vector<std::vector<std::uint8_t>> limits_;
  std::vector<Set> sets_;  // one more than may be in flight: the last collected one stays valid
  std::size_t oldest_ = 0, in_flight_ = 0;
  std::vector<std::uint8_t> bright_;
  std::vector<std::uint32_t> stack_;
  std::string name_ = "reference", problem_;
};

}  // namespace

std::unique_ptr<Detector> make_reference_detector(std::span<const CameraFormat> cameras,
                                                  const DetectorOptions& options) {
  check_set_up(cameras, options);
  return std::make_unique<ReferenceDetector>(cameras, options);
}

}  // namespace glint::gpu
