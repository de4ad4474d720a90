// SPDX-License-Identifier: MIT
// Segments between the start of the image and the start of its scan.
#include "host/capture/jpeg/jpeg_layout.hpp"

#include <algorithm>
#include <string_view>

namespace glint {
namespace {

enum : std::uint8_t {
  kBaseline = 0xc0,
  kExtended = 0xc1,
  kHuffman = 0xc4,
  kStartOfImage = 0xd8,
  kStartOfScan = 0xda,
  kQuantizers = 0xdb,
  kRestartInterval = 0xdd,
  kApplicationFirst = 0xe0,  // JFIF
  kAdobe = 0xee,
  kApplicationLast = 0xef,
  kComment = 0xfe,
};

/// Bytes from the front of a file; what is not there reads as 0 and shows in good().
class Bytes {
 public:
  explicit Bytes(std::span<const std::uint8_t> bytes) noexcept : bytes_(bytes) {}
  std::uint8_t byte() noexcept {
    if (at_ < bytes_.size()) return bytes_[at_++];
    good_ = false;
    return 0;
  }
  std::uint16_t word() noexcept {
    const unsigned high = byte();
    return static_cast<std::uint16_t>(high << 8 | byte());
  }
  /// The next `count` bytes as bytes of their own.
  Bytes part(std::size_t count) noexcept {
    if (count > left()) {
      good_ = false;
      count = 0;
    }
    Bytes part(bytes_.subspan(at_, count));
    at_ += count;
    return part;
  }
  std::size_t left() const noexcept { return bytes_.size() - at_; }
  std::size_t at() const noexcept { return at_; }
  bool good() const noexcept { return good_; }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
  bool good_ = true;
};

// Where libjpeg-turbo draws the line.
constexpr std::uint32_t kLongestSide_px = 65500;
constexpr unsigned kMostBlocksInUnit = 10;

/// Segments of applications, of which two say how the picture is to be understood. Adobe's colours may be
/// other than brightness and two differences.
bool read_application(std::uint8_t marker, Bytes part) noexcept {
  std::array<std::uint8_t, 14> head{};
  const std::size_t length = part.left();
  for (std::uint8_t& byte : head) byte = part.byte();
  const auto starts_with = [&head](std::string_view word) {
    return std::equal(word.begin(), word.end(), head.begin(),
                      [](char c, std::uint8_t byte) { return static_cast<std::uint8_t>(c) == byte; });
  };
  constexpr std::string_view kJfifWord("JFIF", 5);  // with its 0
  if (marker == kApplicationFirst && length >= 14 && starts_with(kJfifWord)) return head[5] == 1;  // version
  if (marker == kAdobe && length >= 12 && starts_with("Adobe")) return head[11] == 1;
  return true;
}

bool read_quantizers(Bytes part, JpegLayout& layout) noexcept {
  while (part.left() > 0) {
    const std::uint8_t head = part.byte();
    if ((head & 0xf) >= JpegLayout::kTables || head >> 4 != 0) return false;
    auto& steps = layout.quantizers[head & 0xf].emplace();
    for (std::uint16_t& step : steps) step = part.byte();
    if (std::find(steps.begin(), steps.end(), 0) != steps.end()) return false;
  }
  return part.good();
}

bool read_huffman(Bytes part, JpegLayout& layout) noexcept {
  while (part.left() > 0) {
    const std::uint8_t head = part.byte();
    if ((head & 0xf) >= JpegLayout::kTables || head >> 4 > 1) return false;
    HuffmanCodes codes;
    std::size_t symbols = 0;
    for (std::uint8_t& count : codes.of_length) symbols += count = part.byte();
    if (symbols > codes.symbols.size()) return false;
    for (std::size_t n = 0; n < symbols; ++n) codes.symbols[n] = part.byte();
    (head >> 4 == 0 ? layout.dc : layout.ac)[head & 0xf] = codes;
  }
  return part.good();
}

/// Some programs tell by these names that no component is brightness.
bool red_green_blue(const std::array<JpegComponent, JpegLayout::kMostComponents>& components) noexcept {
  return components[0].id == 'R' && components[1].id == 'G' && components[2].id == 'B';
}

bool read_frame(Bytes part, JpegLayout& layout) noexcept {
  if (layout.component_count != 0 || part.byte() != 8) return false;  // a second frame; bits of a sample
  layout.size.height_px = part.word();
  layout.size.width_px = part.word();
  layout.component_count = part.byte();
  if (layout.size.width_px == 0 || layout.size.height_px == 0) return false;
  if (std::max(layout.size.width_px, layout.size.height_px) > kLongestSide_px) return false;
  if (layout.component_count != 1 && layout.component_count != JpegLayout::kMostComponents) return false;
  for (JpegComponent& component : std::span(layout.components).first(layout.component_count)) {
    component.id = part.byte();
    const std::uint8_t sampling = part.byte();
    component.across = sampling >> 4;
    component.down = sampling & 0xf;
    component.quantizer = part.byte();
    const JpegComponent& brightness = layout.components[0];
    if (component.across < 1 || component.across > brightness.across || component.across > 4) return false;
    if (component.down < 1 || component.down > brightness.down || component.down > 4) return false;
    if (component.quantizer >= JpegLayout::kTables) return false;
  }
  unsigned blocks = 0;
  for (const JpegComponent& component : std::span(layout.components).first(layout.component_count))
    blocks += unsigned{component.across} * component.down;
  if (layout.component_count > 1 && (blocks > kMostBlocksInUnit || red_green_blue(layout.components)))
    return false;
  // Of a single component, blocks follow each other row by row whatever its sampling.
  if (layout.component_count == 1) layout.components[0].across = layout.components[0].down = 1;
  return part.good() && part.left() == 0;
}

bool read_scan(Bytes part, JpegLayout& layout) noexcept {
  if (layout.component_count == 0 || part.byte() != layout.component_count) return false;
  for (JpegComponent& component : std::span(layout.components).first(layout.component_count)) {
    if (part.byte() != component.id || !layout.quantizers[component.quantizer]) return false;
    const std::uint8_t tables = part.byte();
    component.dc_table = tables >> 4;
    component.ac_table = tables & 0xf;
    if (component.dc_table >= JpegLayout::kTables || component.ac_table >= JpegLayout::kTables) return false;
  }
  const bool whole = part.byte() == 0 && part.byte() == 63 && part.byte() == 0;
  return whole && part.good() && part.left() == 0;
}

}  // namespace

bool read_layout(std::span<const std::uint8_t> jpeg, JpegLayout& layout) noexcept {
  layout.component_count = 0;
  layout.restart_interval = 0;
  layout.quantizers = {};
  Bytes bytes(jpeg);
  if (bytes.byte() != 0xff || bytes.byte() != kStartOfImage) return false;
  for (;;) {
    if (bytes.byte() != 0xff) return false;
    std::uint8_t marker = bytes.byte();
    while (marker == 0xff) marker = bytes.byte();  // padding
    const std::size_t length = bytes.word();
    if (!bytes.good() || length < 2) return false;
    Bytes part = bytes.part(length - 2);
    if (!bytes.good()) return false;
    bool good = false;
    if (marker == kQuantizers) {
      good = read_quantizers(part, layout);
    } else if (marker == kHuffman) {
      good = read_huffman(part, layout);
    } else if (marker == kBaseline || marker == kExtended) {
      good = read_frame(part, layout);
    } else if (marker == kRestartInterval) {
      good = part.left() == 2;
      layout.restart_interval = part.word();
    } else if (marker == kStartOfScan) {
      layout.data_at = bytes.at();
      return read_scan(part, layout);
    } else {
      good = marker == kComment ||
             (marker >= kApplicationFirst && marker <= kApplicationLast && read_application(marker, part));
    }
    if (!good) return false;
  }
}

}  // namespace glint
