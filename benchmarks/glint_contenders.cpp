// SPDX-License-Identifier: MIT
// Detectors for a scene, and what only reads its pixels.
#include "benchmarks/glint_contenders.hpp"

#include <atomic>
#include <cstring>

#include "gpu/cpu/workers.hpp"
#include "host/bench/check.hpp"

namespace glint::benchmarks {
namespace {

/// Adds up the pixels of one camera, eight at a time.
std::uint64_t read_pixels(const std::uint8_t* pixels, std::size_t bytes) noexcept {
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i + 8 <= bytes; i += 8) {
    std::uint64_t word;
    std::memcpy(&word, pixels + i, sizeof word);
    sum += word;
  }
  return sum;
}

class Reader {
 public:
  Reader(const Scene& scene, unsigned threads)
      : scene_(scene), workers_(threads - 1, 1, scene.options().cameras, &Reader::work, this) {}
  std::size_t run(unsigned tick) {
    tick_ = tick;
    workers_.start();
    workers_.finish(0);
    return 0;
  }

 private:
  static void work(void* context, unsigned, unsigned item) noexcept {
    Reader& self = *static_cast<Reader*>(context);
    const SceneOptions& o = self.scene_.options();
    self.sum_ += read_pixels(self.scene_.pixels(self.tick_, item),
                             std::size_t{self.scene_.stride_bytes()} * o.height_px);
  }

  const Scene& scene_;
  unsigned tick_ = 0;
  std::atomic<std::uint64_t> sum_{0};  // so that the reading is not optimised away
  gpu::Workers workers_;
};

}  // namespace

std::vector<NamedDetector> glint_detectors(Scene& scene) {
  const std::vector<gpu::CameraFormat> formats = scene.formats();
  std::vector<NamedDetector> detectors;
  for (const unsigned threads : {1u, 2u}) {
    gpu::DetectorOptions options;
    options.threads = threads;
    std::shared_ptr<gpu::Detector> detector = gpu::make_cpu_detector(formats, options);
    detectors.push_back({"glint " + detector->device_name(), std::move(detector)});
  }
  for (const gpu::DeviceInfo& device : gpu::list_devices()) {
    if (!device.usable) continue;
    std::shared_ptr<gpu::Detector> detector = gpu::make_detector(device.uuid, formats, {});
    detector->adopt_frame_memory(scene.memory());
    detectors.push_back({"glint Vulkan, " + device.name, std::move(detector)});
  }
  for (const NamedDetector& named : detectors) bench::set_limits(scene, *named.detector);
  return detectors;
}

Contender as_contender(const Scene& scene, const NamedDetector& named) {
  std::vector<std::vector<gpu::ImageView>> sets;
  for (unsigned tick = 0; tick < scene.options().ticks; ++tick) sets.push_back(scene.images(tick));
  auto batch = std::make_shared<gpu::BlobBatch>();
  return {named.name, [sets, batch, detector = named.detector](unsigned tick) {
            if (detector->submit(sets[tick]) != gpu::RunStatus::Ok ||
                detector->collect(*batch) != gpu::RunStatus::Ok) {
              throw gpu::Error(detector->device_name() + ": " + detector->last_error());
            }
            std::size_t found = 0;
            for (const gpu::CameraBlobs& camera : batch->cameras) found += camera.found;
            return found;
          }};
}

std::vector<Contender> memory_floor(const Scene& scene) {
  std::vector<Contender> contenders;
  for (const unsigned threads : {1u, 2u}) {
    const auto reader = std::make_shared<Reader>(scene, threads);
    contenders.push_back({std::string("read the pixels once, ") + std::to_string(threads) +
                              (threads == 1 ? " thread" : " threads"),
                          [reader](unsigned tick) { return reader->run(tick); }});
  }
  return contenders;
}

}  // namespace glint::benchmarks
