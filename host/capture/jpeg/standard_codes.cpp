// SPDX-License-Identifier: MIT
// Asked of a compressor.
#include "host/capture/jpeg/standard_codes.hpp"

// jpeglib.h uses these without including them.
#include <csetjmp>
#include <cstdio>

#include <jpeglib.h>

#include <algorithm>

#include "host/base/error.hpp"

namespace glint {
namespace {

HuffmanCodes codes_of(const JHUFF_TBL* table) noexcept {
  HuffmanCodes codes;
  if (table == nullptr) return codes;
  std::copy_n(table->bits + 1, codes.of_length.size(), codes.of_length.begin());
  std::copy_n(table->huffval, codes.symbols.size(), codes.symbols.begin());
  return codes;
}

struct Compressor {
  jpeg_compress_struct jpeg{};
  jpeg_error_mgr errors{};
  std::jmp_buf way_out{};
  ~Compressor() { jpeg_destroy_compress(&jpeg); }

  /// Fails in C's way: no destructors may lie between this and the longjmp.
  bool set_up() noexcept {
    jpeg.err = jpeg_std_error(&errors);
    jpeg.client_data = this;
    errors.error_exit = [](j_common_ptr common) {
      std::longjmp(static_cast<Compressor*>(common->client_data)->way_out, 1);
    };
    if (setjmp(way_out) != 0) return false;
    jpeg_create_compress(&jpeg);
    jpeg.input_components = 1;
    jpeg.in_color_space = JCS_GRAYSCALE;
    jpeg_set_defaults(&jpeg);
    return true;
  }
};

}  // namespace

StandardCodes standard_codes() {
  Compressor compressor;
  if (!compressor.set_up()) throw Error("libjpeg-turbo cannot be started (out of memory?)");
  StandardCodes standard;
  for (std::size_t n = 0; n < 2; ++n) {
    standard.dc[n] = codes_of(compressor.jpeg.dc_huff_tbl_ptrs[n]);
    standard.ac[n] = codes_of(compressor.jpeg.ac_huff_tbl_ptrs[n]);
  }
  return standard;
}

}  // namespace glint
