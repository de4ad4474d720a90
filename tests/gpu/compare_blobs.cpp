// SPDX-License-Identifier: MIT
// Comparison blob by blob, after sorting by everything that is an integer.
#include "tests/gpu/compare_blobs.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <vector>

namespace glint::gpu::testing {
namespace {

auto integers(const BlobRecord& b) {
  return std::make_tuple(b.y_min_px, b.x_min_px, b.area_px, b.sum, b.y_max_px, b.x_max_px, b.weight, b.peak,
                         b.flags, b.camera);
}

bool close(float expected, float actual, double absolute, double relative) {
  const double e = static_cast<double>(expected), a = static_cast<double>(actual);
  return std::abs(e - a) <= absolute + relative * std::abs(e);
}

std::vector<BlobRecord> sorted(std::span<const BlobRecord> blobs) {
  std::vector<BlobRecord> result(blobs.begin(), blobs.end());
  std::sort(result.begin(), result.end(), [](const BlobRecord& a, const BlobRecord& b) {
    return std::tuple(integers(a), a.x_px, a.y_px) < std::tuple(integers(b), b.x_px, b.y_px);
  });
  return result;
}

std::string describe(const BlobRecord& b) {
  return "blob at (" + std::to_string(b.x_px) + ", " + std::to_string(b.y_px) + "), box " +
         std::to_string(b.x_min_px) + ".." + std::to_string(b.x_max_px) + " x " + std::to_string(b.y_min_px) +
         ".." + std::to_string(b.y_max_px) + ", area " + std::to_string(b.area_px) + ", sum " +
         std::to_string(b.sum) + ", weight " + std::to_string(b.weight) + ", peak " + std::to_string(b.peak) +
         ", flags " + std::to_string(b.flags) + ", camera " + std::to_string(b.camera) + ", undistorted (" +
         std::to_string(b.x_undist) + ", " + std::to_string(b.y_undist) + "), moments " +
         std::to_string(b.var_xx_px2) + " " + std::to_string(b.var_xy_px2) + " " +
         std::to_string(b.var_yy_px2);
}

}  // namespace

::testing::AssertionResult same_blobs(const CameraBlobs& expected, const CameraBlobs& actual,
                                      const Lens& lens) {
  if (expected.found != actual.found || expected.overflow != actual.overflow ||
      expected.blobs.size() != actual.blobs.size()) {
    return ::testing::AssertionFailure()
           << "expected " << expected.found << " found, " << expected.blobs.size() << " kept, overflow "
           << expected.overflow << "; got " << actual.found << ", " << actual.blobs.size() << ", "
           << actual.overflow;
  }
  const auto key = [](const BlobRecord& b) { return std::tuple(b.y_min_px, b.x_min_px, b.area_px, b.sum); };
  if (!std::is_sorted(actual.blobs.begin(), actual.blobs.end(),
                      [&](const BlobRecord& a, const BlobRecord& b) { return key(a) < key(b); })) {
    return ::testing::AssertionFailure() << "blobs are not sorted by (y_min, x_min, area, sum)";
  }
  const std::vector<BlobRecord> e = sorted(expected.blobs), a = sorted(actual.blobs);
  for (std::size_t i = 0; i < e.size(); ++i) {
    const auto differs = [&](const char* what) {
      return ::testing::AssertionFailure()
             << what << " of blob " << i << " of " << e.size() << "\n  expected " << describe(e[i])
             << "\n  got      " << describe(a[i]);
    };
    if (integers(e[i]) != integers(a[i])) return differs("an integer");
    if (!close(e[i].x_px, a[i].x_px, 0.001, 0) || !close(e[i].y_px, a[i].y_px, 0.001, 0))
      return differs("the centroid");
    // A covariance is as good as the variances it belongs to.
    const double var = static_cast<double>(e[i].var_xx_px2) + static_cast<double>(e[i].var_yy_px2);
    if (!close(e[i].var_xx_px2, a[i].var_xx_px2, 1e-3, 1e-3) ||
        !close(e[i].var_yy_px2, a[i].var_yy_px2, 1e-3, 1e-3) ||
        !close(e[i].var_xy_px2, a[i].var_xy_px2, 1e-3 + 1e-3 * var, 0)) {
      return differs("a second moment");
    }
    if ((e[i].flags & shaders::kBlobNotInvertible) != 0) continue;
    if (!close(e[i].x_undist, a[i].x_undist, 0.001 / std::abs(lens.fx_px), 0) ||
        !close(e[i].y_undist, a[i].y_undist, 0.001 / std::abs(lens.fy_px), 0)) {
      return differs("the undistorted point");
    }
  }
  return ::testing::AssertionSuccess();
}

void set_limits(Detector& detector, std::span<const TestImage> images) {
  for (std::uint32_t i = 0; i < images.size(); ++i) detector.set_limit(i, images[i].limit);
}

BlobBatch detect(Detector& detector, std::span<const ImageView> images) {
  BlobBatch batch;
  EXPECT_EQ(detector.submit(images), RunStatus::Ok) << detector.last_error();
  EXPECT_EQ(detector.collect(batch), RunStatus::Ok) << detector.last_error();
  EXPECT_EQ(batch.cameras.size(), images.size());
  batch.cameras.resize(images.size());  // so that a failure is no crash
  return batch;
}

void expect_equal_to_reference(const DetectorCase& detector, std::span<const TestImage> images,
                               DetectorOptions options) {
  const std::vector<CameraFormat> formats = formats_of(images);
  FrameMemory memory(images, detector.layout);
  std::vector<ImageView> views = memory.views();
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (images[i].pixels.empty()) views[i].pixels = nullptr;
  }
  const auto reference = make_reference_detector(formats, options);
  const auto tested = detector.make(formats, options);
  if (detector.adopt) tested->adopt_frame_memory(memory.memory());
  set_limits(*reference, images);
  set_limits(*tested, images);
  const BlobBatch expected = detect(*reference, views), actual = detect(*tested, views);
  for (std::size_t i = 0; i < images.size(); ++i) {
    EXPECT_TRUE(same_blobs(expected.cameras[i], actual.cameras[i], formats[i].lens))
        << tested->device_name() << ", camera " << i << ": " << images[i].name << ", " << images[i].width_px
        << "x" << images[i].height_px;
  }
}

}  // namespace glint::gpu::testing
