// SPDX-License-Identifier: MIT
// OpenCV's ArUco dictionaries, where glint is built with OpenCV (GLINT_OPENCV). Only for this module's
// sources.
#pragma once

#include <string>
#include <string_view>

#include "host/base/error.hpp"

#if GLINT_OPENCV
#include <opencv2/aruco.hpp>
#endif

namespace glint {

#if GLINT_OPENCV

/// One that marker_bits.hpp knows.
cv::Ptr<cv::aruco::Dictionary> open_dictionary(std::string_view name);

#else

[[noreturn]] inline void throw_no_opencv(const std::string& what) {
  throw Error(what +
              ": this glint was built without OpenCV. Install it (host/install_packages target) and build "
              "glint anew; cmake then finds it");
}

#endif

}  // namespace glint
