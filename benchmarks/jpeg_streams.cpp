// SPDX-License-Identifier: MIT
// Rendered and compressed once, decoded every tick.
#include "benchmarks/jpeg_streams.hpp"

#include <turbojpeg.h>

#include <chrono>
#include <ctime>
#include <stdexcept>
#include <thread>

#include "host/sim/renderer.hpp"
#include "host/sim/rig.hpp"

namespace glint::benchmarks {

JpegPictures::JpegPictures(const Scene& scene, unsigned ticks, int quality) : ticks_(ticks) {
  const SimOptions& options = scene.options();
  const FrameSize size{options.width_px, options.height_px};
  for (const CameraCalibration& camera : sim_calibration(options).cameras)
    names_.push_back({camera.name, size});
  const std::unique_ptr<void, int (*)(void*)> compressor(tjInitCompress(), tjDestroy);
  std::vector<std::uint8_t> grey(std::size_t{size.width_px} * size.height_px);
  const int width = static_cast<int>(size.width_px), height = static_cast<int>(size.height_px);
  std::vector<unsigned char> room(tjBufSize(width, height, TJSAMP_GRAY));
  sim::Renderer renderer(scene);
  for (unsigned tick = 0; tick < ticks; ++tick) {
    for (std::uint32_t camera = 0; camera < names_.size(); ++camera) {
      sim::BufferMemory fresh;
      renderer.render(camera, tick, grey.data(), size.width_px, fresh);
      unsigned char* jpeg = room.data();
      unsigned long bytes = room.size();
      if (tjCompress2(compressor.get(), grey.data(), width, 0, height, TJPF_GRAY, &jpeg, &bytes, TJSAMP_GRAY,
                      quality, TJFLAG_NOREALLOC) != 0)
        throw std::runtime_error(tjGetErrorStr2(compressor.get()));
      const auto all = std::as_bytes(std::span(room).first(bytes));
      jpegs_.emplace_back(all.begin(), all.end());
    }
  }
}

std::span<const std::byte> JpegPictures::picture(std::uint64_t n, std::size_t camera) const noexcept {
  const std::uint64_t turn = ticks_ > 1 ? n % (2 * ticks_ - 2) : 0;
  const std::uint64_t tick = turn < ticks_ ? turn : 2 * ticks_ - 2 - turn;
  return jpegs_[tick * names_.size() + camera];
}

double JpegPictures::mean_bytes() const noexcept {
  std::size_t sum = 0;
  for (const auto& jpeg : jpegs_) sum += jpeg.size();
  return static_cast<double>(sum) / static_cast<double>(jpegs_.size());
}

double thread_cpu_s() noexcept {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + static_cast<double>(time.tv_nsec) * 1e-9;
}

JpegStreams::JpegStreams(const JpegPictures& pictures, std::uint64_t sets, double rate_hz, bool paced,
                         bool whole)
    : pictures_(pictures),
      sets_(sets),
      rate_hz_(rate_hz),
      paced_(paced),
      whole_(whole),
      decoders_(pictures.cameras()),
      workers_(static_cast<unsigned>(pictures.cameras()) - 1, 1, static_cast<unsigned>(pictures.cameras()),
               &JpegStreams::decode, this) {}

void JpegStreams::set_limit(std::uint32_t camera, std::span<const std::uint8_t> limit) {
  if (!whole_) decoders_[camera].set_limit(limit, pictures_.described()[camera].size);
}

void JpegStreams::decode(void* context, unsigned, unsigned camera) noexcept {
  JpegStreams& self = *static_cast<JpegStreams*>(context);
  std::optional<Frame>& frame = self.set_->frames[camera];
  if (!frame) return;
  const double before_s = thread_cpu_s();
  const GreyTarget target{frame->pixels().data(), frame->stride_bytes(),
                          self.pictures_.described()[camera].size};
  if (self.decoders_[camera].decode(self.pictures_.picture(self.next_, camera), target) != JpegResult::Good)
    ++self.bad_;
  self.cpu_ns_ += static_cast<std::int64_t>((thread_cpu_s() - before_s) * 1e9);
}

ReadStatus JpegStreams::read(FramePool& pool, FrameSet& set) noexcept {
  for (auto& frame : set.frames) frame.reset();
  if (next_ == sets_) return ReadStatus::End;
  if (next_ == 0) started_ = std::chrono::steady_clock::now();
  set.exposed = std::chrono::steady_clock::now();
  if (paced_) {
    const std::chrono::duration<double> since(static_cast<double>(next_) / rate_hz_);
    set.exposed = started_ + std::chrono::duration_cast<Timestamp::duration>(since);
    std::this_thread::sleep_until(set.exposed);
  }
  set.trigger = TriggerNo(next_);
  for (std::uint32_t camera = 0; camera < pictures_.cameras(); ++camera) {
    set.frames[camera] = pool.take(CameraId(camera));
    if (!set.frames[camera]) {
      ++counters_.no_slot;
      continue;
    }
    set.frames[camera]->camera = CameraId(camera);
    set.frames[camera]->sequence = static_cast<std::uint32_t>(next_);
    ++counters_.frames;
  }
  set_ = &set;
  workers_.start();
  workers_.finish(0);
  ++next_;
  if (bad_.load() == 0) return ReadStatus::Ok;
  problem_ = "a JPEG was not decoded";
  return ReadStatus::Failed;
}

}  // namespace glint::benchmarks
