// SPDX-License-Identifier: MIT
// Blob by blob against the reference detector.
#include "host/bench/check.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include "host/base/error.hpp"

namespace glint::bench {
namespace {

constexpr double kCentroid_px = 0.001;
constexpr double kMoment = 0.001;  // of a variance, and as much in px^2

/// "" if the detector did its work.
std::string detect(gpu::Detector& detector, const std::vector<gpu::ImageView>& images,
                   gpu::BlobBatch& batch) {
  if (detector.submit(images) == gpu::RunStatus::Ok && detector.collect(batch) == gpu::RunStatus::Ok)
    return "";
  return "it failed: " + detector.last_error();
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.9g", value);
  return text;
}

/// Which field differs, with both values; "" if none does.
std::string difference(const gpu::BlobRecord& expected, const gpu::BlobRecord& actual,
                       const gpu::Lens& lens) {
  using Record = gpu::BlobRecord;
  static constexpr std::array<std::pair<const char*, std::uint32_t Record::*>, 9> kIntegers{
      {{"area_px", &Record::area_px},
       {"sum", &Record::sum},
       {"weight", &Record::weight},
       {"peak", &Record::peak},
       {"x_min_px", &Record::x_min_px},
       {"y_min_px", &Record::y_min_px},
       {"x_max_px", &Record::x_max_px},
       {"y_max_px", &Record::y_max_px},
       {"flags", &Record::flags}}};
  for (const auto& [name, field] : kIntegers) {
    if (expected.*field == actual.*field) continue;
    return std::string(name) + " is " + std::to_string(actual.*field) + " instead of " +
           std::to_string(expected.*field);
  }
  const double variances =
      static_cast<double>(expected.var_xx_px2) + static_cast<double>(expected.var_yy_px2);
  struct Real {
    const char* name;
    float Record::*field;
    double tolerance;
  };
  const std::array<Real, 7> reals{{{"x_px", &Record::x_px, kCentroid_px},
                                   {"y_px", &Record::y_px, kCentroid_px},
                                   {"var_xx_px2", &Record::var_xx_px2, kMoment * (1.0 + variances)},
                                   {"var_xy_px2", &Record::var_xy_px2, kMoment * (1.0 + variances)},
                                   {"var_yy_px2", &Record::var_yy_px2, kMoment * (1.0 + variances)},
                                   {"x_undist", &Record::x_undist, kCentroid_px / lens.fx_px},
                                   {"y_undist", &Record::y_undist, kCentroid_px / lens.fy_px}}};
  for (const Real& real : reals) {
    const double e = static_cast<double>(expected.*real.field), a = static_cast<double>(actual.*real.field);
    if (std::abs(e - a) <= real.tolerance) continue;  // not so for NaN
    return std::string(real.name) + " is " + number(a) + " instead of " + number(e);
  }
  return "";
}

}  // namespace

void set_limits(const Scene& scene, gpu::Detector& detector, unsigned cameras) {
  for (unsigned i = 0; i < cameras; ++i) detector.set_limit(i, scene.limit(i));
}

void set_limits(const Scene& scene, gpu::Detector& detector) {
  set_limits(scene, detector, scene.options().cameras);
}

Expected::Expected(const Scene& scene) : scene_(scene) {
  const unsigned drawn = scene.drawn_cameras();
  const std::vector<gpu::CameraFormat> all = scene.formats();
  const std::vector<gpu::CameraFormat> formats(all.begin(), all.begin() + drawn);
  const auto reference = gpu::make_reference_detector(formats, {});
  for (unsigned i = 0; i < drawn; ++i) reference->set_limit(i, scene.limit(i));
  gpu::BlobBatch batch;
  for (unsigned tick = 0; tick < scene.options().ticks; ++tick) {
    std::vector<gpu::ImageView> images = scene.images(tick);
    images.resize(drawn);
    if (const std::string problem = detect(*reference, images, batch); !problem.empty())
      throw Error("the reference detector: " + problem);
    std::vector<Image>& expected = ticks_.emplace_back();
    for (const gpu::CameraBlobs& camera : batch.cameras) {
      if (camera.overflow) {
        throw Error("a picture shows " + std::to_string(camera.found) +
                    " bright spots, more than a detector keeps: ask for fewer blobs or less noise");
      }
      expected.push_back({{camera.blobs.begin(), camera.blobs.end()}, camera.found});
    }
  }
}

std::string Expected::difference(gpu::Detector& detector, unsigned cameras) const {
  const gpu::Lens lens = scene_.formats().front().lens;
  gpu::BlobBatch batch;
  for (unsigned tick = 0; tick < ticks_.size(); ++tick) {
    const std::string when = "tick " + std::to_string(tick);
    std::vector<gpu::ImageView> images = scene_.images(tick);
    images.resize(cameras);
    if (const std::string problem = detect(detector, images, batch); !problem.empty())
      return when + ": " + problem;
    if (batch.cameras.size() != cameras)
      return when + ": blobs of " + std::to_string(batch.cameras.size()) + " cameras";
    for (std::size_t i = 0; i < cameras; ++i) {
      const Image& expected = ticks_[tick][i % scene_.drawn_cameras()];
      const gpu::CameraBlobs& actual = batch.cameras[i];
      const std::string where = when + ", camera " + std::to_string(i + 1);
      if (expected.found != actual.found || expected.blobs.size() != actual.blobs.size() || actual.overflow) {
        return where + ": " + std::to_string(actual.blobs.size()) + " blobs" +
               (actual.overflow ? " and an overflow" : "") + " instead of " +
               std::to_string(expected.blobs.size());
      }
      for (std::size_t b = 0; b < expected.blobs.size(); ++b) {
        if (actual.blobs[b].camera != i)
          return where + ": a blob of camera " + std::to_string(actual.blobs[b].camera + 1);
        const std::string what = bench::difference(expected.blobs[b], actual.blobs[b], lens);
        if (!what.empty()) return where + ", blob " + std::to_string(b + 1) + ": " + what;
      }
    }
  }
  return "";
}

std::size_t Expected::found(unsigned tick, unsigned cameras) const noexcept {
  const std::vector<Image>& images = ticks_[tick];
  std::size_t found = 0;
  for (unsigned i = 0; i < cameras; ++i) found += images[i % images.size()].found;
  return found;
}

}  // namespace glint::bench
