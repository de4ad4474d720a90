// SPDX-License-Identifier: MIT
// Any bytes as a Motion JPEG. What must hold: nothing is written beside the picture; what the decoder for
// bright pixels takes, libjpeg-turbo takes too, and both show the same above the limit; and no picture spoils
// the next one.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "host/base/check.hpp"
#include "host/capture/jpeg/jpeg_decoder.hpp"
#include "tests/fuzz/jpeg_input.hpp"
#include "tests/unit/capture/grey_jpeg.hpp"

namespace glint {
namespace {

using Grey = std::vector<std::uint8_t>;

constexpr std::uint8_t kGuard = 0xa5;
constexpr std::size_t kGuards = 64;  // before the first row and behind the last

/// A picture with bytes around it and between its rows that must stay what they are.
class GuardedPicture {
 public:
  GuardedPicture(FrameSize size, std::size_t gap)
      : size_(size), stride_(size.width_px + gap), bytes_(2 * kGuards + stride_ * size.height_px, kGuard) {}

  GreyTarget target() { return {bytes_.data() + kGuards, stride_, size_}; }
  std::uint8_t at(std::size_t x, std::size_t y) const { return bytes_[kGuards + y * stride_ + x]; }
  bool guards_stand() const {
    const auto untouched = [this](std::size_t from, std::size_t to) {
      return std::all_of(bytes_.begin() + static_cast<std::ptrdiff_t>(from),
                         bytes_.begin() + static_cast<std::ptrdiff_t>(to),
                         [](std::uint8_t byte) { return byte == kGuard; });
    };
    bool stand = untouched(0, kGuards) && untouched(bytes_.size() - kGuards, bytes_.size());
    for (std::size_t y = 0; y < size_.height_px; ++y) {
      const std::size_t row = kGuards + y * stride_;
      stand = stand && untouched(row + size_.width_px, row + stride_);
    }
    return stand;
  }

 private:
  FrameSize size_;
  std::size_t stride_;
  Grey bytes_;
};

void check_alike(const GuardedPicture& bright, const GuardedPicture& whole, const Grey& limit,
                 FrameSize size) {
  for (std::size_t y = 0; y < size.height_px; ++y) {
    for (std::size_t x = 0; x < size.width_px; ++x) {
      const std::uint8_t most = limit[y * size.width_px + x];
      if (bright.at(x, y) > most || whole.at(x, y) > most) GLINT_CHECK(bright.at(x, y) == whole.at(x, y));
    }
  }
}

/// A faultless picture of each size, one without tables among them, and what it shows.
struct Known {
  Grey jpeg;
  GuardedPicture shows;
};

std::vector<Known> known_pictures() {
  std::vector<Known> all;
  for (const FrameSize size : test::kJpegSizes) {
    const Grey picture = test::disc_picture(size.width_px, size.height_px, 3);
    const Grey jpeg =
        test::without_huffman_tables(test::jpeg_of(picture, size.width_px, size.height_px, 90, true));
    Known known{jpeg, GuardedPicture(size, 0)};
    FullJpegDecoder fresh;
    GLINT_CHECK(fresh.decode(std::as_bytes(std::span(jpeg)), known.shows.target()) == JpegResult::Good);
    all.push_back(std::move(known));
  }
  return all;
}

void run(std::span<const std::uint8_t> input) {
  static const std::vector<Known> kKnown = known_pictures();
  // These live on, as a camera's do: what one picture leaves behind must not show in another.
  static BrightJpegDecoder bright;
  static FullJpegDecoder full;
  static JpegDecoder both;
  if (input.size() < test::kJpegInputBytes) return;
  const test::JpegInput how{input[0], input[1], input[2], input[3]};
  const std::span<const std::byte> jpeg = std::as_bytes(input.subspan(test::kJpegInputBytes));
  const std::size_t index = how.size % test::kJpegSizes.size(), gap = how.gap % 16;
  const FrameSize size = test::kJpegSizes[index];
  Grey limit(std::size_t{size.width_px} * size.height_px);
  for (std::size_t n = 0; n < limit.size(); ++n)
    limit[n] = static_cast<std::uint8_t>(std::max<std::size_t>(how.limit, (how.limit + n * how.rise) % 256));
  bright.set_limit(limit, size);
  both.set_limit(limit, size);

  GuardedPicture some(size, gap), whole(size, gap), either(size, gap);
  const bool taken = bright.decode(jpeg, some.target());
  const JpegResult result = full.decode(jpeg, whole.target());
  GLINT_CHECK(some.guards_stand());
  GLINT_CHECK(whole.guards_stand());
  GLINT_CHECK(both.decode(jpeg, either.target()) == result);
  GLINT_CHECK(either.guards_stand());
  if (taken) {
    GLINT_CHECK(result == JpegResult::Good);
    check_alike(some, whole, limit, size);
  }
  if (result == JpegResult::Good) check_alike(either, whole, limit, size);

  const Known& known = kKnown[index];
  const std::span<const std::byte> good = std::as_bytes(std::span(known.jpeg));
  GLINT_CHECK(bright.decode(good, some.target()));
  check_alike(some, known.shows, limit, size);
  GLINT_CHECK(full.decode(good, whole.target()) == JpegResult::Good);
  check_alike(whole, known.shows, Grey(limit.size(), 0), size);
}

}  // namespace
}  // namespace glint

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  glint::run({data, size});
  return 0;
}
