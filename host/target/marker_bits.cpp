// SPDX-License-Identifier: MIT
// The dictionaries' names, and their markers out of OpenCV.
#include "host/target/marker_bits.hpp"

#include <string>

#include "host/base/check.hpp"
#include "host/target/aruco.hpp"

namespace glint {

std::uint32_t markers_in(std::string_view dictionary) {
  const auto number = dictionary_number(dictionary);
  if (!number) return 0;
  constexpr std::uint32_t kSizes[] = {50, 100, 250, 1000};
  return *number < 16 ? kSizes[*number % 4] : 1024;
}

std::optional<unsigned> dictionary_number(std::string_view dictionary) {
  unsigned number = 0;
  for (const char* const bits : {"4X4", "5X5", "6X6", "7X7"}) {
    for (const char* const size : {"_50", "_100", "_250", "_1000"}) {
      if (dictionary == std::string(bits) + size) return number;
      ++number;
    }
  }
  if (dictionary == "ARUCO_ORIGINAL") return number;
  return std::nullopt;
}

#if GLINT_OPENCV

MarkerBits marker_bits(std::string_view dictionary, std::uint32_t id) {
  GLINT_CHECK(id < markers_in(dictionary));
  const auto set = open_dictionary(dictionary);
  const auto row = static_cast<int>(id);
  const cv::Mat inner =
      cv::aruco::Dictionary::getBitsFromByteList(set->bytesList.rowRange(row, row + 1), set->markerSize);
  MarkerBits bits;
  bits.side = static_cast<std::uint32_t>(set->markerSize) + 2;
  bits.black.assign(bits.side * bits.side, true);
  for (int y = 0; y < set->markerSize; ++y) {
    for (int x = 0; x < set->markerSize; ++x) {
      bits.black[(static_cast<std::uint32_t>(y) + 1) * bits.side + static_cast<std::uint32_t>(x) + 1] =
          inner.at<unsigned char>(y, x) == 0;
    }
  }
  return bits;
}

cv::Ptr<cv::aruco::Dictionary> open_dictionary(std::string_view name) {
  const auto number = dictionary_number(name);
  GLINT_CHECK(number.has_value());
  // Of OpenCV's releases some give the dictionary, others a pointer to it.
  struct Pointer {
    cv::Ptr<cv::aruco::Dictionary> operator()(cv::Ptr<cv::aruco::Dictionary> d) const { return d; }
    cv::Ptr<cv::aruco::Dictionary> operator()(const cv::aruco::Dictionary& d) const {
      return cv::makePtr<cv::aruco::Dictionary>(d);
    }
  };
  return Pointer{}(
      cv::aruco::getPredefinedDictionary(static_cast<cv::aruco::PREDEFINED_DICTIONARY_NAME>(*number)));
}

#else

MarkerBits marker_bits(std::string_view, std::uint32_t) { throw_no_opencv("ArUco markers"); }

#endif

}  // namespace glint
