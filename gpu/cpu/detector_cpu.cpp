// SPDX-License-Identifier: MIT
// Cameras and bands of rows shared out to threads; the bands of a camera are joined by whoever ends last.
#include "gpu/cpu/detector_cpu.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <deque>
#include <string>
#include <vector>

#include "gpu/cpu/band_labeller.hpp"
#include "gpu/cpu/lens_inverse.hpp"
#include "gpu/cpu/limit_image.hpp"
#include "gpu/cpu/set_up.hpp"
#include "gpu/cpu/workers.hpp"

namespace glint::gpu {
namespace {

using Clock = std::chrono::steady_clock;

/// How many bands of rows a camera is cut into: enough items that threads end at about the same time,
/// not so many that joining them costs.
std::uint32_t bands_of(std::uint32_t height_px, std::size_t cameras, unsigned threads) noexcept {
  constexpr std::uint32_t kItemsPerThread = 8, kLeastRows = 48;
  if (threads == 1) return 1;
  const auto wanted = static_cast<std::uint32_t>((kItemsPerThread * threads + cameras - 1) / cameras);
  return std::max(1u, std::min(wanted, height_px / kLeastRows));
}

/// Calls touch(i, j) for every run i of `upper` that is 8-connected to run j of `lower`, the row below.
template <typename Touch>
void for_touching_runs(const BorderRow& upper, const BorderRow& lower, std::uint32_t stride,
                       Touch touch) noexcept {
  std::size_t first = 0;
  for (std::size_t j = 0; j < lower.runs.size(); ++j) {
    const PixelRun run = lower.runs[j];
    while (first < upper.runs.size() && upper.runs[first].end + stride < run.begin) ++first;
    for (std::size_t i = first; i < upper.runs.size() && upper.runs[i].begin + stride <= run.end; ++i)
      touch(i, j);
  }
}

/// One camera in one frame set: its bands and what came out.
class CameraJob {
 public:
  CameraJob(const CameraFormat& format, std::uint32_t camera, std::uint32_t bands, std::size_t max_blobs)
      : format_(format),
        inverse_(format),
        camera_(camera),
        open_(bands == 1 ? 0 : std::size_t{bands} * Band::slots_needed(format.width_px)),
        kept_(max_blobs) {
    for (std::uint32_t b = 0; b < bands; ++b) {
      const auto row = [&](std::uint32_t n) {
        return static_cast<std::uint32_t>(std::uint64_t{format.height_px} * n / bands);
      };
      const std::size_t most = std::size_t{(format.width_px + 1) / 2} * ((row(b + 1) - row(b) + 1) / 2);
      bands_.emplace_back(format.width_px, row(b), row(b + 1), b > 0, b + 1 < bands,
                          b * Band::slots_needed(format.width_px), std::min(max_blobs, most));
    }
    records_.reserve(max_blobs);
  }

  void start(const ImageView& image) noexcept {
    image_ = image;
    bands_left_.store(static_cast<std::uint32_t>(bands_.size()), std::memory_order_relaxed);
  }

  /// Any thread, once per band; the last one to end finishes the camera.
  void run_band(std::uint32_t band, const LimitImage& limit, const RowKernels& kernels,
                const AreaFilter& filter, BandLabeller& labeller) noexcept {
    if (image_.pixels == nullptr) {
      bands_[band].clear();
    } else {
      labeller.run(limit.rows(image_), kernels, filter, bands_[band], open_);
    }
    if (bands_left_.fetch_sub(1, std::memory_order_acq_rel) == 1) finish(filter);
  }

  CameraBlobs blobs() const noexcept {
    return {records_, kept_.offered(), kept_.offered() > records_.size()};
  }

 private:
  void finish(const AreaFilter& filter) noexcept {
    kept_.clear();
    const std::uint32_t stride = position_stride(format_.width_px);
    for (std::size_t b = 0; b + 1 < bands_.size(); ++b) {
      const BorderRow &upper = bands_[b].last, &lower = bands_[b + 1].first;
      for_touching_runs(upper, lower, stride, [&](std::size_t i, std::size_t j) {
        const std::uint32_t above = open_.root(upper.slots[i]), below = open_.root(lower.slots[j]);
        if (above != below) open_.join(above, below);
      });
    }
    for (const Band& band : bands_) {
      for (const BorderRow* row : {&band.first, &band.last}) {
        for (const std::uint32_t slot : row->slots) {
          Component& component = open_[open_.root(slot)];
          if (component.note == kGivenOut) continue;
          component.note = kGivenOut;
          filter.offer(component.moments, kept_);
        }
      }
      kept_.offer_all(band.finished);
    }
    records_.clear();
    kept_.for_each_in_order([this](const BlobMoments& blob) {
      const BlobShape s = shape_of(blob);
      const Undistorted u = inverse_.undistort_blob(s.x_px, s.y_px, s.var_xx_px2, s.var_xy_px2, s.var_yy_px2);
      records_.push_back(to_record(blob, s, u, camera_, format_));
    });
  }

  static constexpr std::uint32_t kGivenOut = 1;  // Component::note, which bands set to something else

  CameraFormat format_;
  LensInverse inverse_;
  std::uint32_t camera_;
  ImageView image_;
  ComponentTable open_;  // blobs that reach into more than one band
  std::vector<Band> bands_;
  std::atomic<std::uint32_t> bands_left_{0};
  KeepFirst kept_;
  std::vector<BlobRecord> records_;
};

/// One labeller per thread. There are as many as threads, so one is always free.
class Labellers {
 public:
  Labellers(unsigned threads, std::uint32_t max_width_px) {
    for (unsigned i = 0; i < threads; ++i) desks_.emplace_back(max_width_px);
  }
  template <typename Work>
  void with_one(Work work) noexcept {
    for (std::size_t i = 0;; i = (i + 1) % desks_.size()) {
      if (desks_[i].taken.exchange(true, std::memory_order_acquire)) continue;
      work(desks_[i].labeller);
      desks_[i].taken.store(false, std::memory_order_release);
      return;
    }
  }

 private:
  struct alignas(64) Desk {
    explicit Desk(std::uint32_t max_width_px) : labeller(max_width_px) {}
    BandLabeller labeller;
    std::atomic<bool> taken{false};
  };
  std::deque<Desk> desks_;
};

class CpuDetector final : public Detector {
 public:
  CpuDetector(std::span<const CameraFormat> cameras, const DetectorOptions& options,
              const RowKernels& kernels)
      : cameras_(cameras.begin(), cameras.end()),
        kernels_(kernels),
        filter_{options.min_area_px, options.max_area_px},
        depth_(options.depth),
        labellers_(options.threads, std::max_element(cameras.begin(), cameras.end(),
                                                     [](const CameraFormat& a, const CameraFormat& b) {
                                                       return a.width_px < b.width_px;
                                                     })
                                        ->width_px),
        name_("cpu (" + std::to_string(options.threads) +
              (options.threads == 1 ? " thread, " : " threads, ") + kernels.name + ")") {
    problem_.reserve(kProblemBytes);
    for (std::uint32_t i = 0; i < cameras_.size(); ++i) {
      const CameraFormat& format = cameras_[i];
      limits_.emplace_back(format.width_px, format.height_px);
      const std::uint32_t bands = bands_of(format.height_px, cameras_.size(), options.threads);
      for (std::uint32_t b = 0; b < bands; ++b) items_.push_back({i, b});
    }
    for (unsigned s = 0; s <= depth_; ++s) {
      Set& set = sets_.emplace_back();
      for (std::uint32_t i = 0; i < cameras_.size(); ++i) {
        const CameraFormat& format = cameras_[i];
        const std::size_t most = std::size_t{(format.width_px + 1) / 2} * ((format.height_px + 1) / 2);
        set.cameras.push_back(std::make_unique<CameraJob>(
            format, i, bands_of(format.height_px, cameras_.size(), options.threads),
            std::min<std::size_t>(options.max_blobs_per_camera, most)));
      }
    }
    workers_ = std::make_unique<Workers>(options.threads - 1, static_cast<unsigned>(sets_.size()),
                                         static_cast<unsigned>(items_.size()), &CpuDetector::work, this);
  }

  const std::string& device_name() const noexcept override { return name_; }

  void set_limit(std::uint32_t camera, std::span<const std::uint8_t> limit) override {
    check_limit(cameras_, camera, limit.size(), in_flight_);
    limits_[camera].set(limit);
  }

  bool adopt_frame_memory(std::span<std::byte>) override { return true; }
  void upload(std::uint32_t, const ImageView&) noexcept override {}

  RunStatus submit(std::span<const ImageView> images) noexcept override {
    if (in_flight_ == depth_) return RunStatus::Busy;
    if (const RunStatus status = check_images(cameras_, images, problem_); status != RunStatus::Ok)
      return status;
    Set& set = sets_[(oldest_ + in_flight_) % sets_.size()];
    for (std::size_t i = 0; i < images.size(); ++i) set.cameras[i]->start(images[i]);
    set.items_left.store(static_cast<std::uint32_t>(items_.size()), std::memory_order_relaxed);
    workers_->start();
    ++in_flight_;
    return RunStatus::Ok;
  }

  RunStatus collect(BlobBatch& batch) noexcept override {
    if (in_flight_ == 0) return RunStatus::Idle;
    workers_->finish(static_cast<unsigned>(oldest_));
    const Set& set = sets_[oldest_];
    oldest_ = (oldest_ + 1) % sets_.size();
    --in_flight_;
    batch.cameras.resize(cameras_.size());
    for (std::size_t i = 0; i < cameras_.size(); ++i) batch.cameras[i] = set.cameras[i]->blobs();
    batch.stages.resize(1);
    batch.stages[0] = {"detect", std::chrono::duration<double>(set.ended - set.began).count()};
    return RunStatus::Ok;
  }

  const std::string& last_error() const noexcept override { return problem_; }

 private:
  struct Item {
    std::uint32_t camera, band;
  };
  struct Set {
    std::vector<std::unique_ptr<CameraJob>> cameras;
    std::atomic<std::uint32_t> items_left{0};
    Clock::time_point began, ended;  // the first item's start, the last item's end
  };

  static void work(void* context, unsigned slot, unsigned item) noexcept {
    auto& self = *static_cast<CpuDetector*>(context);
    Set& set = self.sets_[slot];
    if (item == 0) set.began = Clock::now();
    const auto [camera, band] = self.items_[item];
    self.labellers_.with_one([&](BandLabeller& labeller) {
      set.cameras[camera]->run_band(band, self.limits_[camera], self.kernels_, self.filter_, labeller);
    });
    if (set.items_left.fetch_sub(1, std::memory_order_acq_rel) == 1) set.ended = Clock::now();
  }

  std::vector<CameraFormat> cameras_;
  RowKernels kernels_;
  AreaFilter filter_;
  unsigned depth_;
  std::vector<LimitImage> limits_;
  Labellers labellers_;
  std::vector<Item> items_;
  std::deque<Set> sets_;  // one more than may be in flight: the last collected one stays valid
  std::size_t oldest_ = 0, in_flight_ = 0;
  std::string name_, problem_;
  std::unique_ptr<Workers> workers_;  // last: its threads end before what they use
};

}  // namespace

std::unique_ptr<Detector> make_cpu_detector(std::span<const CameraFormat> cameras,
                                            const DetectorOptions& options, const RowKernels& kernels) {
  check_set_up(cameras, options);
  return std::make_unique<CpuDetector>(cameras, options, kernels);
}

std::unique_ptr<Detector> make_cpu_detector(std::span<const CameraFormat> cameras,
                                            const DetectorOptions& options) {
  return make_cpu_detector(cameras, options, row_kernels().front());
}

}  // namespace glint::gpu
