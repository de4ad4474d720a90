// SPDX-License-Identifier: MIT
// Corners of chess squares below the pixel. Only for this module's sources, and with OpenCV.
#pragma once

#include <opencv2/core.hpp>

#include "host/target/board_finder.hpp"

namespace glint {

/// Moves `corner` to where the grey levels around it have their saddle, looking `reach_px` to each side.
/// False if there is none within reach or the window leaves the image.
bool refine_saddle_point(const cv::Mat& image, int reach_px, cv::Point2f& corner);

/// The picture as OpenCV sees it, not copied; not to be written.
cv::Mat as_matrix(const GreyPicture& picture);

}  // namespace glint
