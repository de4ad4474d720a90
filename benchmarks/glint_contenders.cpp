// SPDX-License-Identifier: MIT
// Detectors for a scene, and the check that they are right.
#include "benchmarks/glint_contenders.hpp"

#include <atomic>
#include <cmath>
#include <cstring>
#include <tuple>

#include "gpu/cpu/workers.hpp"

namespace glint::benchmarks {
namespace {

void set_limits(const Scene& scene, gpu::Detector& detector) {
  for (unsigned i = 0; i < scene.options().cameras; ++i) detector.set_limit(i, scene.limit(i));
}

gpu::BlobBatch detect(gpu::Detector& detector, const std::vector<gpu::ImageView>& images) {
  gpu::BlobBatch batch;
  if (detector.submit(images) != gpu::RunStatus::Ok || detector.collect(batch) != gpu::RunStatus::Ok) {
    throw gpu::Error(detector.device_name() + ": " + detector.last_error());
  }
  return batch;
}

bool same(const gpu::BlobRecord& a, const gpu::BlobRecord& b, const gpu::Lens& lens) {
  const auto integers = [](const gpu::BlobRecord& r) {
    return std::tie(r.area_px, r.sum, r.weight, r.peak, r.x_min_px, r.y_min_px, r.x_max_px, r.y_max_px,
                    r.flags);
  };
  const auto close = [](float x, float y, double scale) {
    return std::abs(static_cast<double>(x) - static_cast<double>(y)) * scale <= 0.001;
  };
  return integers(a) == integers(b) && close(a.x_px, b.x_px, 1.0) && close(a.y_px, b.y_px, 1.0) &&
         close(a.x_undist, b.x_undist, lens.fx_px) && close(a.y_undist, b.y_undist, lens.fy_px);
}

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
    self.sum_ += read_pixels(self.scene_.pixels(self.tick_, item), std::size_t{o.width_px} * o.height_px);
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
  for (const NamedDetector& named : detectors) set_limits(scene, *named.detector);
  return detectors;
}

std::string difference_from_reference(const Scene& scene, gpu::Detector& detector) {
  const std::vector<gpu::CameraFormat> formats = scene.formats();
  const auto reference = gpu::make_reference_detector(formats, {});
  set_limits(scene, *reference);
  for (unsigned tick = 0; tick < scene.options().ticks; ++tick) {
    const gpu::BlobBatch expected = detect(*reference, scene.images(tick));
    const gpu::BlobBatch actual = detect(detector, scene.images(tick));
    for (std::size_t i = 0; i < formats.size(); ++i) {
      const auto e = expected.cameras[i].blobs, a = actual.cameras[i].blobs;
      const std::string where = "tick " + std::to_string(tick) + ", camera " + std::to_string(i) + ": ";
      if (e.size() != a.size() || expected.cameras[i].found != actual.cameras[i].found) {
        return where + std::to_string(a.size()) + " blobs instead of " + std::to_string(e.size());
      }
      for (std::size_t b = 0; b < e.size(); ++b) {
        if (!same(e[b], a[b], formats[i].lens)) return where + "blob " + std::to_string(b) + " differs";
      }
    }
  }
  return "";
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
