// SPDX-License-Identifier: MIT
// The steps, one OpenCV call after the other.
#include "benchmarks/opencv_steps.hpp"

#include <algorithm>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

namespace glint::benchmarks {
namespace {

constexpr double kThesisThreshold = 200.0;

}  // namespace

OpenCvCamera::OpenCvCamera(const gpu::CameraFormat& format, std::span<const std::uint8_t> background) {
  const int rows = static_cast<int>(format.height_px), columns = static_cast<int>(format.width_px);
  background_ = cv::Mat(rows, columns, CV_8UC1);
  std::copy(background.begin(), background.end(), background_.data);
  const gpu::Lens& lens = format.lens;
  matrix_ = (cv::Mat_<double>(3, 3) << lens.fx_px, 0, lens.cx_px, 0, lens.fy_px, lens.cy_px, 0, 0, 1);
  distortion_ = cv::Mat(lens.k1_k2_p1_p2_k3, true);
  cv::initUndistortRectifyMap(matrix_, distortion_, cv::Mat(), matrix_, {columns, rows}, CV_16SC2, map1_,
                              map2_);
}

std::size_t OpenCvCamera::find_centres() {
  cv::findContours(bright_, contours_, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  centres_.clear();
  for (const auto& contour : contours_) {
    const cv::Moments m = cv::moments(contour);
    if (m.m00 > 0.0) {
      centres_.emplace_back(m.m10 / m.m00, m.m01 / m.m00);
    } else {  // a line or a point has no area inside its contour
      centres_.emplace_back(contour.front());
    }
  }
  return centres_.size();
}

std::size_t OpenCvCamera::blur_and_find() {
  cv::GaussianBlur(undistorted_, blurred_, cv::Size(5, 5), 0.0);
  cv::threshold(blurred_, bright_, kThesisThreshold, 255.0, cv::THRESH_BINARY);
  return find_centres();
}

std::size_t OpenCvCamera::thesis(const cv::Mat& frame) {
  cv::subtract(frame, background_, difference_);
  cv::undistort(difference_, undistorted_, matrix_, distortion_);
  return blur_and_find();
}

std::size_t OpenCvCamera::thesis_with_maps(const cv::Mat& frame) {
  cv::subtract(frame, background_, difference_);
  cv::remap(difference_, undistorted_, map1_, map2_, cv::INTER_LINEAR);
  return blur_and_find();
}

std::size_t OpenCvCamera::lean(const cv::Mat& frame, double margin) {
  cv::subtract(frame, background_, difference_);
  cv::threshold(difference_, bright_, margin, 255.0, cv::THRESH_BINARY);
  const std::size_t found = find_centres();
  if (found > 0) cv::undistortPoints(centres_, undistorted_centres_, matrix_, distortion_);
  return found;
}

}  // namespace glint::benchmarks
