// SPDX-License-Identifier: MIT
// One camera's way from an image to centres, in OpenCV.
#pragma once

#include <cstddef>
#include <opencv2/core.hpp>
#include <span>
#include <vector>

#include "gpu/detector.hpp"

namespace glint::benchmarks {

/// All images in between are kept from frame to frame, so that none is allocated anew. Each step returns how
/// many centres it found.
class OpenCvCamera {
 public:
  /// background: as many bytes as the camera has pixels.
  OpenCvCamera(const gpu::CameraFormat& format, std::span<const std::uint8_t> background);

  /// As the thesis did: subtract the background, cv::undistort, blur, threshold 200, contours, moments.
  std::size_t thesis(const cv::Mat& frame);
  /// The same with maps made beforehand.
  std::size_t thesis_with_maps(const cv::Mat& frame);
  /// Subtract, threshold at `margin`, contours and moments, undistort the centres.
  std::size_t lean(const cv::Mat& frame, double margin);

 private:
  std::size_t find_centres();
  std::size_t blur_and_find();

  cv::Mat background_, matrix_, distortion_, map1_, map2_;
  cv::Mat difference_, undistorted_, blurred_, bright_;
  std::vector<std::vector<cv::Point>> contours_;
  std::vector<cv::Point2d> centres_, undistorted_centres_;
};

}  // namespace glint::benchmarks
