// SPDX-License-Identifier: MIT
// Refinement by OpenCV.
#include "host/target/saddle_points.hpp"

#include <vector>

#include <opencv2/imgproc.hpp>

namespace glint {

bool refine_saddle_point(const cv::Mat& image, int reach_px, cv::Point2f& corner) {
  const auto outside = [&](const cv::Point2f& p) {
    const auto reach = static_cast<float>(reach_px);
    return !(p.x >= reach && p.y >= reach && p.x <= static_cast<float>(image.cols - 1) - reach &&
             p.y <= static_cast<float>(image.rows - 1) - reach);
  };
  if (outside(corner)) return false;
  // Where it does not converge within the window OpenCV gives back the start; started aside, even a corner
  // that was exact already comes back changed.
  const cv::Point2f start = corner + cv::Point2f(0.31f, 0.17f);
  std::vector<cv::Point2f> one{start};
  cv::cornerSubPix(image, one, {reach_px, reach_px}, {-1, -1},
                   {cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 40, 1e-3});
  if (one[0] == start || outside(one[0])) return false;
  corner = one[0];
  return true;
}

cv::Mat as_matrix(const GreyPicture& picture) {
  return cv::Mat(static_cast<int>(picture.height_px), static_cast<int>(picture.width_px), CV_8UC1,
                 const_cast<std::uint8_t*>(picture.pixels), picture.stride_bytes);
}

}  // namespace glint
