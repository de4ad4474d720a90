// SPDX-License-Identifier: MIT
// The decompressor, its way out of errors, and where its working memory comes from.
#include "host/capture/jpeg/full_decoder.hpp"

// jpeglib.h uses these without including them.
#include <csetjmp>
#include <cstdio>

#include <jpeglib.h>

#include <jerror.h>

#include <algorithm>
#include <array>
#include <new>
#include <vector>

#include "host/base/error.hpp"

namespace glint {
namespace {

// What libjpeg-turbo aligns rows to for its vector code, doubled as it doubles it.
constexpr std::size_t kAlignment = 64;
constexpr std::size_t kFirstBlock_bytes = std::size_t{256} << 10;

constexpr std::size_t aligned(std::size_t bytes) noexcept {
  return (bytes + kAlignment - 1) / kAlignment * kAlignment;
}

/// One block of memory, handed out from the front and taken back as a whole.
class Block {
 public:
  Block() { grow(kFirstBlock_bytes); }

  /// nullptr when there is not enough left; the next clear() makes room.
  void* take(std::size_t bytes) noexcept {
    bytes = aligned(bytes);
    wanted_ += bytes;
    if (bytes > memory_.size() * sizeof(Line) - used_) {
      ++spills_;
      return nullptr;
    }
    void* const place = reinterpret_cast<std::byte*>(memory_.data()) + used_;
    used_ += bytes;
    return place;
  }

  void clear() noexcept {
    if (wanted_ > memory_.size() * sizeof(Line)) {
      try {
        grow(wanted_);
      } catch (const std::bad_alloc&) {
        // Then the library's own memory goes on being used.
      }
    }
    used_ = wanted_ = 0;
  }

  std::uint64_t spills() const noexcept { return spills_; }

 private:
  struct alignas(kAlignment) Line {
    std::array<std::byte, kAlignment> bytes;
  };
  void grow(std::size_t bytes) { memory_ = std::vector<Line>(aligned(bytes) / sizeof(Line)); }

  std::vector<Line> memory_;
  std::size_t used_ = 0, wanted_ = 0;
  std::uint64_t spills_ = 0;
};

}  // namespace

struct FullJpegDecoder::State {
  jpeg_decompress_struct jpeg{};
  jpeg_error_mgr errors{};
  std::jmp_buf way_out{};
  jpeg_memory_mgr library{};  // its own functions
  Block block;
  std::array<JSAMPROW, 16> rows{};  // that one call may fill

  static State& of(j_common_ptr common) noexcept { return *static_cast<State*>(common->client_data); }

  ~State() { jpeg_destroy_decompress(&jpeg); }
  bool create() noexcept;
  void use_block() noexcept;
  JpegResult run(std::span<const std::byte> bytes, const GreyTarget& target) noexcept;
  JpegResult failure() const noexcept {
    return errors.msg_code == JWRN_JPEG_EOF || errors.msg_code == JERR_INPUT_EMPTY ? JpegResult::Truncated
                                                                                   : JpegResult::Corrupt;
  }
};

/// Fails in C's way: no destructors may lie between this and the longjmp.
bool FullJpegDecoder::State::create() noexcept {
  jpeg.err = jpeg_std_error(&errors);
  jpeg.client_data = this;
  errors.error_exit = [](j_common_ptr common) { std::longjmp(of(common).way_out, 1); };
  errors.emit_message = [](j_common_ptr common, int level) {
    if (level < 0) std::longjmp(of(common).way_out, 1);  // a warning is as bad as an error
  };
  errors.output_message = [](j_common_ptr) {};
  if (setjmp(way_out) != 0) return false;
  jpeg_create_decompress(&jpeg);
  static constexpr unsigned char kAnything = 0;
  jpeg_mem_src(&jpeg, &kAnything, 1);  // makes the source that later calls only fill in
  use_block();
  return true;
}

/// From now on all memory lives as long as one picture and comes from the block. A full block falls back to
/// the library's own.
void FullJpegDecoder::State::use_block() noexcept {
  jpeg_memory_mgr& memory = *jpeg.mem;
  library = memory;
  memory.alloc_small = [](j_common_ptr common, int, std::size_t bytes) -> void* {
    State& self = of(common);
    void* const place = self.block.take(bytes);
    return place != nullptr ? place : self.library.alloc_small(common, JPOOL_IMAGE, bytes);
  };
  memory.alloc_large = [](j_common_ptr common, int, std::size_t bytes) -> void* {
    State& self = of(common);
    void* const place = self.block.take(bytes);
    return place != nullptr ? place : self.library.alloc_large(common, JPOOL_IMAGE, bytes);
  };
  memory.alloc_sarray = [](j_common_ptr common, int, JDIMENSION width, JDIMENSION height) -> JSAMPARRAY {
    State& self = of(common);
    const std::size_t row_bytes = aligned(width), list_bytes = aligned(height * sizeof(JSAMPROW));
    void* const place = self.block.take(list_bytes + row_bytes * height);
    if (place == nullptr) return self.library.alloc_sarray(common, JPOOL_IMAGE, width, height);
    auto* const list = static_cast<JSAMPARRAY>(place);
    JSAMPROW row = static_cast<JSAMPROW>(place) + list_bytes;
    for (JDIMENSION n = 0; n < height; ++n, row += row_bytes) list[n] = row;
    return list;
  };
  memory.free_pool = [](j_common_ptr common, int pool) {
    State& self = of(common);
    if (pool == JPOOL_IMAGE) self.block.clear();
    self.library.free_pool(common, pool);
  };
}

JpegResult FullJpegDecoder::State::run(std::span<const std::byte> bytes, const GreyTarget& target) noexcept {
  // Tables outlive a picture, by the library's habit: those of a corrupt one that passed for good must not
  // serve the next, which may bring none. Without any, the standard ones serve.
  std::fill_n(jpeg.quant_tbl_ptrs, NUM_QUANT_TBLS, nullptr);
  std::fill_n(jpeg.dc_huff_tbl_ptrs, NUM_HUFF_TBLS, nullptr);
  std::fill_n(jpeg.ac_huff_tbl_ptrs, NUM_HUFF_TBLS, nullptr);
  if (setjmp(way_out) != 0) return failure();
  jpeg_mem_src(&jpeg, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size());
  jpeg_read_header(&jpeg, TRUE);
  if (jpeg.image_width != target.size.width_px || jpeg.image_height != target.size.height_px)
    return JpegResult::WrongSize;
  // No camera sends these, and they could keep a decoder busy for minutes.
  if (jpeg.progressive_mode || jpeg.arith_code || jpeg_has_multiple_scans(&jpeg)) return JpegResult::Corrupt;
  jpeg.out_color_space = JCS_GRAYSCALE;
  jpeg_start_decompress(&jpeg);
  while (jpeg.output_scanline < jpeg.output_height) {
    const std::size_t left = std::min<std::size_t>(rows.size(), jpeg.output_height - jpeg.output_scanline);
    for (std::size_t n = 0; n < left; ++n)
      rows[n] = target.pixels + (jpeg.output_scanline + n) * target.stride_bytes;
    jpeg_read_scanlines(&jpeg, rows.data(), static_cast<JDIMENSION>(left));
  }
  jpeg_finish_decompress(&jpeg);  // reads on to the end marker
  return JpegResult::Good;
}

FullJpegDecoder::FullJpegDecoder() : state_(std::make_unique<State>()) {
  if (!state_->create()) throw Error("libjpeg-turbo cannot be started (out of memory?)");
}

FullJpegDecoder::~FullJpegDecoder() = default;

JpegResult FullJpegDecoder::decode(std::span<const std::byte> jpeg, const GreyTarget& target) noexcept {
  const JpegResult result = state_->run(jpeg, target);
  if (result != JpegResult::Good) jpeg_abort_decompress(&state_->jpeg);
  return result;
}

std::uint64_t FullJpegDecoder::spills() const noexcept { return state_->block.spills(); }

}  // namespace glint
