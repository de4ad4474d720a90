// SPDX-License-Identifier: MIT
// Comments in JPEG files, and dark pixels.
#include "tests/device/frame_file/pulse_tag.hpp"

#include <array>
#include <cstring>

namespace glint::device {
namespace {

constexpr std::size_t kStartBytes = 2;                                           // FF D8
constexpr std::array<std::uint8_t, 6> kComment{0xFF, 0xFE, 0x00, 12, 'P', ':'};  // marker, length, our mark
constexpr std::size_t kTagBytes = kComment.size() + 8;

}  // namespace

std::vector<std::uint8_t> with_pulse_comment(std::span<const std::uint8_t> jpeg, std::uint64_t pulse) {
  std::vector<std::uint8_t> tagged(jpeg.size() + kTagBytes);
  std::uint8_t* to = tagged.data();
  std::memcpy(to, jpeg.data(), kStartBytes);
  std::memcpy(to + kStartBytes, kComment.data(), kComment.size());
  std::memcpy(to + kStartBytes + kComment.size(), &pulse, 8);
  std::memcpy(to + kStartBytes + kTagBytes, jpeg.data() + kStartBytes, jpeg.size() - kStartBytes);
  return tagged;
}

std::optional<std::uint64_t> pulse_of_comment(std::span<const std::uint8_t> jpeg) noexcept {
  if (jpeg.size() < kStartBytes + kTagBytes ||
      std::memcmp(jpeg.data() + kStartBytes, kComment.data(), kComment.size()) != 0)
    return std::nullopt;
  std::uint64_t pulse = 0;
  std::memcpy(&pulse, jpeg.data() + kStartBytes + kComment.size(), 8);
  return pulse;
}

bool ends_whole(std::span<const std::uint8_t> jpeg) noexcept {
  while (!jpeg.empty() && jpeg.back() == 0) jpeg = jpeg.first(jpeg.size() - 1);
  return jpeg.size() >= 4 && jpeg[jpeg.size() - 2] == 0xFF && jpeg.back() == 0xD9;
}

void put_pulse(std::span<std::uint8_t, kGreyTagPixels> pixels, std::uint64_t pulse) noexcept {
  for (std::uint8_t& pixel : pixels) {
    pixel = pulse & 15u;
    pulse >>= 4;
  }
}

std::uint64_t get_pulse(std::span<const std::uint8_t, kGreyTagPixels> pixels) noexcept {
  std::uint64_t pulse = 0;
  for (std::size_t i = pixels.size(); i-- > 0;) pulse = pulse << 4 | (pixels[i] & 15u);
  return pulse;
}

}  // namespace glint::device
