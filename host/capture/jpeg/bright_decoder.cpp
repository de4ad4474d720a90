// SPDX-License-Identifier: MIT
// Codes to coefficients, and the bound that spares most blocks the rest.
#include "host/capture/jpeg/bright_decoder.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "host/base/check.hpp"
#include "host/capture/jpeg/standard_codes.hpp"

namespace glint {
namespace {

constexpr std::int32_t kUnits = 64;       // of a grey level, in which brightness is bounded
constexpr std::int32_t kMostMean = 1024;  // of 8-bit pictures less 128, times 8

/// The largest value of a cosine of that frequency on eight pixels, with its factor in the transform.
double most_of_frequency(unsigned frequency) noexcept {
  if (frequency == 0) return std::sqrt(0.125);
  double most = 0.0;
  for (unsigned pixel = 0; pixel < 8; ++pixel)
    most = std::max(most, std::abs(std::cos((2 * pixel + 1) * frequency * M_PI / 16.0)));
  return most / 2.0;
}

/// What a coefficient of 1 adds to a pixel at most, in the order of JpegBlock.
std::array<double, 64> most_of_places() noexcept {
  std::array<double, 64> most{};
  for (unsigned place = 0; place < 64; ++place)
    most[place] = most_of_frequency(place / 8) * most_of_frequency(place % 8);
  return most;
}

std::uint32_t blocks_over(std::uint32_t pixels, std::uint32_t block = 8) noexcept {
  return (pixels + block - 1) / block;
}

}  // namespace

BrightJpegDecoder::BrightJpegDecoder() : standard_(standard_codes()) {}

void BrightJpegDecoder::set_limit(std::span<const std::uint8_t> limit, FrameSize size) {
  GLINT_CHECK(limit.size() == std::size_t{size.width_px} * size.height_px);
  size_ = size;
  columns_ = blocks_over(size.width_px);
  rows_ = blocks_over(size.height_px);
  darkest_limit_.assign(std::size_t{columns_} * rows_, 255);
  for (std::uint32_t y = 0; y < size.height_px; ++y) {
    for (std::uint32_t x = 0; x < size.width_px; ++x) {
      std::int32_t& darkest = darkest_limit_[std::size_t{y / 8} * columns_ + x / 8];
      darkest = std::min<std::int32_t>(darkest, limit[std::size_t{y} * size.width_px + x]);
    }
  }
  for (std::int32_t& darkest : darkest_limit_) darkest = (darkest - 128) * kUnits;
  means_.assign(kMostDown * columns_, 0);
  line_.assign(std::size_t{columns_} * 8, 0);
  bright_.reserve(kMostDown * columns_);
  data_.reserve(limit.size());
}

bool BrightJpegDecoder::prepare() noexcept {
  static const std::array<double, 64> kMost = most_of_places();
  for (std::size_t n = 0; n < layout_.component_count; ++n) {
    const JpegComponent& component = layout_.components[n];
    HuffmanTable &dc = dc_[component.dc_table], &ac = ac_[component.ac_table];
    if (!dc.set(layout_.dc[component.dc_table], HuffmanTable::Kind::Dc)) return false;
    if (!ac.set(layout_.ac[component.ac_table], HuffmanTable::Kind::Ac)) return false;
    tables_[n].dc = &dc;
    tables_[n].ac = &ac;
  }
  const auto& steps = *layout_.quantizers[layout_.components[0].quantizer];
  for (std::size_t n = 0; n < 64; ++n) {
    step_[n] = steps[n];
    tables_[0].weight[n] = static_cast<std::int32_t>(std::ceil(steps[n] * kMost[kPlaceInBlock[n]] * kUnits));
  }
  return true;
}

bool BrightJpegDecoder::decode(std::span<const std::byte> jpeg, const GreyTarget& target) noexcept {
  const std::span<const std::uint8_t> file(reinterpret_cast<const std::uint8_t*>(jpeg.data()), jpeg.size());
  layout_.dc = standard_.dc;
  layout_.ac = standard_.ac;
  if (!has_limit(target.size) || !read_layout(file, layout_)) return false;
  if (layout_.size.width_px != size_.width_px || layout_.size.height_px != size_.height_px) return false;
  if (!prepare() || !data_.read(file.subspan(layout_.data_at)) || !decode_units(target)) return false;
  blocks_ += darkest_limit_.size();
  return true;
}

/// A unit holds the blocks of all components for one piece of the picture.
bool BrightJpegDecoder::decode_units(const GreyTarget& target) noexcept {
  // Copies, because bytes written to memory could change members, for all that the compiler knows.
  const std::uint32_t across = layout_.components[0].across, down = layout_.components[0].down;
  const std::uint32_t columns = columns_, rows = rows_;
  const std::size_t components = layout_.component_count;
  const std::int32_t mean_step = step_[0];
  const std::int32_t* const limits = darkest_limit_.data();
  std::uint8_t* const means = means_.data();
  const std::uint32_t units = blocks_over(columns, across) * blocks_over(rows, down);
  const std::uint32_t interval = layout_.restart_interval == 0 ? units : layout_.restart_interval;
  if (data_.parts() != blocks_over(units, interval)) return false;
  JpegBlockReader reader(tables_[0]), second(tables_[1]), third(tables_[2]);
  std::array<JpegNumbers, JpegBlockReader::kMostNumbers> numbers;
  const auto pass_over = [&](EntropyBits& bits, JpegBlockReader& colour, const JpegComponent& component) {
    for (unsigned block = 0; block < unsigned{component.across} * component.down; ++block)
      if (!colour.read(bits, numbers.data())) return false;
    return true;
  };
  std::uint32_t unit = 0, column = 0, row = 0;  // in blocks of brightness
  bright_.clear();
  for (std::size_t n = 0; n < data_.parts(); ++n) {
    EntropyBits bits(data_.part(n));
    reader.restart();
    for (const std::uint32_t last = std::min(units, unit + interval); unit < last; ++unit) {
      for (std::uint32_t y = row; y < row + down; ++y) {
        for (std::uint32_t x = column; x < column + across; ++x) {
          if (!reader.read(bits, numbers.data())) return false;
          if (x >= columns || y >= rows) continue;  // fills up the last unit
          const std::int32_t mean = reader.mean() * mean_step;
          // Rounding aside, no picture has more, and what libjpeg-turbo makes of it is its own.
          if (std::abs(mean) > kMostMean + mean_step) return false;
          means[(y - row) * columns + x] =
              static_cast<std::uint8_t>(std::clamp(128 + ((mean + 4) >> 3), 0, 255));
          const std::int32_t room = limits[std::size_t{y} * columns + x] - mean * (kUnits / 8);
          if (reader.weight() <= room) [[likely]]
            continue;
          const std::span<const JpegNumbers> all = std::span(numbers).first(reader.count());
          if (!stays_below(room, reader.weight(), all) && !transform(x, y, mean, all)) return false;
        }
      }
      if (components > 1 &&
          !(pass_over(bits, second, layout_.components[1]) && pass_over(bits, third, layout_.components[2])))
        return false;
      column += across;
      if (column < columns) continue;
      for (std::uint32_t y = row; y < std::min(rows, row + down); ++y)
        put_means(y, &means[(y - row) * columns], target);
      put_bright(target);
      column = 0;
      row += down;
    }
    if (!bits.finished()) return false;
  }
  return true;
}

/// All pixels of a block.
bool BrightJpegDecoder::transform(std::uint32_t column, std::uint32_t row, std::int32_t mean,
                                  std::span<const JpegNumbers> numbers) noexcept {
  block_.coefficients[0] = mean;
  for (const JpegNumbers& two : numbers) {
    const std::size_t first = two.first_place() % 64, second = two.second_place() % 64;
    block_.coefficients[kPlaceInBlock[first]] += two.pair.first * step_[first];
    block_.coefficients[kPlaceInBlock[second]] += two.pair.second * step_[second];
  }
  // There is room for a row of them.
  BrightBlock& bright = bright_.emplace_back(BrightBlock{column, row, {}});
  const bool tame = transform_block(block_, bright.pixels.data(), 8);
  block_.coefficients.fill(0);
  return tame;
}

/// Fills a row of blocks with their means.
void BrightJpegDecoder::put_means(std::uint32_t row, const std::uint8_t* means,
                                  const GreyTarget& target) noexcept {
  for (std::uint32_t n = 0; n < columns_; ++n) std::memset(&line_[std::size_t{n} * 8], means[n], 8);
  for (std::uint32_t y = row * 8; y < std::min(row * 8 + 8, size_.height_px); ++y)
    std::memcpy(target.pixels + y * target.stride_bytes, line_.data(), size_.width_px);
}

void BrightJpegDecoder::put_bright(const GreyTarget& target) noexcept {
  for (const BrightBlock& block : bright_) {
    const std::uint32_t x = block.column * 8, y = block.row * 8;
    const std::size_t width = std::min(8u, size_.width_px - x), height = std::min(8u, size_.height_px - y);
    std::uint8_t* const pixels = target.pixels + y * target.stride_bytes + x;
    if (width == 8 && height == 8) [[likely]] {
      for (std::size_t n = 0; n < 8; ++n)
        std::memcpy(pixels + n * target.stride_bytes, &block.pixels[n * 8], 8);
    } else {
      for (std::size_t n = 0; n < height; ++n)
        std::memcpy(pixels + n * target.stride_bytes, &block.pixels[n * 8], width);
    }
  }
  transformed_ += bright_.size();
  bright_.clear();
}

/// The sum of the squares of what all coefficients add to the block's pixels (the transform is orthonormal)
/// is the most that the square of one pixel can be. With noise in all coefficients this says more than the
/// sum of what each adds at most.
bool BrightJpegDecoder::stays_below(std::int32_t room, std::int32_t sum_of_most,
                                    std::span<const JpegNumbers> numbers) const noexcept {
  // Of 63 coefficients it is at least half of that sum.
  if (room <= 0 || sum_of_most > 2 * room) return false;
  float sum = 0.0f;
  for (const JpegNumbers& two : numbers) {
    const float first = static_cast<float>(two.pair.first * step_[two.first_place() % 64]);
    const float second = static_cast<float>(two.pair.second * step_[two.second_place() % 64]);
    sum += first * first + second * second;
  }
  const float most = static_cast<float>(room) / kUnits;
  return sum <= most * most;
}

}  // namespace glint
