// SPDX-License-Identifier: MIT
// The dictionaries' names, and their markers out of OpenCV.
#include "host/target/marker_bits.hpp"

#include <algorithm>
#include <iterator>

#include "host/base/check.hpp"
#include "host/target/aruco.hpp"

namespace glint {

namespace {

struct KnownDictionary {
  std::string_view name;
  std::uint32_t markers;
};

/// In the order of OpenCV's numbers.
constexpr KnownDictionary kDictionaries[] = {
    {"4X4_50", 50},           {"4X4_100", 100},      {"4X4_250", 250},      {"4X4_1000", 1000},
    {"5X5_50", 50},           {"5X5_100", 100},      {"5X5_250", 250},      {"5X5_1000", 1000},
    {"6X6_50", 50},           {"6X6_100", 100},      {"6X6_250", 250},      {"6X6_1000", 1000},
    {"7X7_50", 50},           {"7X7_100", 100},      {"7X7_250", 250},      {"7X7_1000", 1000},
    {"ARUCO_ORIGINAL", 1024}, {"APRILTAG_16h5", 30}, {"APRILTAG_25h9", 35}, {"APRILTAG_36h10", 2320},
    {"APRILTAG_36h11", 587},
};

bool same_but_for_case(std::string_view a, std::string_view b) {
  const auto small = [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c; };
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [small](char x, char y) { return small(x) == small(y); });
}

const KnownDictionary* find_dictionary(std::string_view name) {
  constexpr std::string_view kPrefix = "DICT_";
  if (same_but_for_case(name.substr(0, kPrefix.size()), kPrefix)) name.remove_prefix(kPrefix.size());
  const auto* const found =
      std::find_if(std::begin(kDictionaries), std::end(kDictionaries),
                   [name](const KnownDictionary& known) { return same_but_for_case(known.name, name); });
  return found == std::end(kDictionaries) ? nullptr : found;
}

}  // namespace

std::string_view dictionary_name(std::string_view typed) {
  const KnownDictionary* const known = find_dictionary(typed);
  return known != nullptr ? known->name : std::string_view();
}

std::uint32_t markers_in(std::string_view dictionary) {
  const KnownDictionary* const known = find_dictionary(dictionary);
  return known != nullptr ? known->markers : 0;
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
  const KnownDictionary* const known = find_dictionary(name);
  GLINT_CHECK(known != nullptr);
  // Of OpenCV's releases some give the dictionary, others a pointer to it.
  struct Pointer {
    cv::Ptr<cv::aruco::Dictionary> operator()(cv::Ptr<cv::aruco::Dictionary> d) const { return d; }
    cv::Ptr<cv::aruco::Dictionary> operator()(const cv::aruco::Dictionary& d) const {
      return cv::makePtr<cv::aruco::Dictionary>(d);
    }
  };
  return Pointer{}(cv::aruco::getPredefinedDictionary(
      static_cast<cv::aruco::PREDEFINED_DICTIONARY_NAME>(known - kDictionaries)));
}

#else

MarkerBits marker_bits(std::string_view, std::uint32_t) { throw_no_opencv("ArUco markers"); }

#endif

}  // namespace glint
