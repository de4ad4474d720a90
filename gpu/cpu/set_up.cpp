// SPDX-License-Identifier: MIT
// Checks before the first frame, and the one check per frame.
#include "gpu/cpu/set_up.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "gpu/cpu/blob_moments.hpp"

namespace glint::gpu {

void check_set_up(std::span<const CameraFormat> cameras, const DetectorOptions& options) {
  if (cameras.empty() || cameras.size() > kMaxCameras) {
    throw Error("detector: " + std::to_string(cameras.size()) + " cameras; 1 to " +
                std::to_string(kMaxCameras) + " are possible");
  }
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const CameraFormat& camera = cameras[i];
    const std::string who = "detector: camera " + std::to_string(i) + ": ";
    if (camera.width_px == 0 || camera.height_px == 0 || camera.width_px > kMaxSide ||
        camera.height_px > kMaxSide || std::uint64_t{camera.width_px} * camera.height_px > kMaxPixels) {
      throw Error(who + std::to_string(camera.width_px) + "x" + std::to_string(camera.height_px) +
                  " px; sides of 1 to " + std::to_string(kMaxSide) + " px and at most " +
                  std::to_string(kMaxPixels) + " pixels are possible");
    }
    const Lens& lens = camera.lens;
    const bool finite = std::isfinite(lens.fx_px) && std::isfinite(lens.fy_px) && std::isfinite(lens.cx_px) &&
                        std::isfinite(lens.cy_px) &&
                        std::all_of(lens.k1_k2_p1_p2_k3.begin(), lens.k1_k2_p1_p2_k3.end(),
                                    [](double k) { return std::isfinite(k); });
    if (!finite || lens.fx_px == 0.0 || lens.fy_px == 0.0) {
      throw Error(who +
                  "the lens has a focal length of 0 or a number that is not finite; check its calibration");
    }
  }
  if (options.min_area_px > options.max_area_px) {
    throw Error("detector: min_area_px " + std::to_string(options.min_area_px) + " is above max_area_px " +
                std::to_string(options.max_area_px));
  }
  if (options.max_blobs_per_camera == 0) throw Error("detector: max_blobs_per_camera must be at least 1");
  if (options.threads == 0 || options.threads > 256) throw Error("detector: threads must be 1 to 256");
  if (options.depth == 0 || options.depth > 16) throw Error("detector: depth must be 1 to 16");
}

void check_limit(std::span<const CameraFormat> cameras, std::uint32_t camera, std::size_t limit_bytes,
                 std::size_t in_flight) {
  if (in_flight != 0) throw Error("detector: the limit image cannot change while sets are in flight");
  if (camera >= cameras.size()) {
    throw Error("detector: a limit image for camera " + std::to_string(camera) + " of " +
                std::to_string(cameras.size()));
  }
  const CameraFormat& format = cameras[camera];
  const std::size_t needed = std::size_t{format.width_px} * format.height_px;
  if (limit_bytes != needed) {
    throw Error("detector: the limit image of camera " + std::to_string(camera) + " has " +
                std::to_string(limit_bytes) + " bytes; " + std::to_string(format.width_px) + "x" +
                std::to_string(format.height_px) + " = " + std::to_string(needed) + " are needed");
  }
}

RunStatus check_images(std::span<const CameraFormat> cameras, std::span<const ImageView> images,
                       std::string& problem) noexcept {
  char text[kProblemBytes];
  if (images.size() != cameras.size()) {
    std::snprintf(text, sizeof text, "%zu images for %zu cameras", images.size(), cameras.size());
    problem.assign(text);
    return RunStatus::BadImage;
  }
  for (std::size_t i = 0; i < images.size(); ++i) {
    const ImageView& image = images[i];
    if (image.pixels == nullptr) continue;
    if (image.width_px != cameras[i].width_px || image.height_px != cameras[i].height_px ||
        image.stride_bytes < image.width_px || image.format != PixelFormat::Grey8) {
      std::snprintf(
          text, sizeof text, "camera %zu gave %ux%u px with stride %u; it should be %ux%u px of 8-bit grey",
          i, image.width_px, image.height_px, image.stride_bytes, cameras[i].width_px, cameras[i].height_px);
      problem.assign(text);
      return RunStatus::BadImage;
    }
  }
  return RunStatus::Ok;
}

}  // namespace glint::gpu
