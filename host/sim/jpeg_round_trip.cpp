// SPDX-License-Identifier: MIT
// JPEG there and back through libjpeg-turbo.
#include "host/sim/jpeg_round_trip.hpp"

#include <turbojpeg.h>

#include "host/base/error.hpp"

namespace glint::sim {

void JpegRoundTrip::Close::operator()(void* handle) const noexcept { tjDestroy(handle); }

JpegRoundTrip::JpegRoundTrip(std::uint32_t width_px, std::uint32_t height_px, int quality)
    : width_px_(width_px),
      height_px_(height_px),
      quality_(quality),
      compressor_(tjInitCompress()),
      decompressor_(tjInitDecompress()),
      bytes_(tjBufSize(static_cast<int>(width_px), static_cast<int>(height_px), TJSAMP_GRAY)) {
  if (!compressor_ || !decompressor_)
    throw Error("simulated rig: libjpeg-turbo cannot be started (out of memory?)");
}

bool JpegRoundTrip::apply(std::uint8_t* pixels, std::uint32_t stride_bytes) noexcept {
  const int width = static_cast<int>(width_px_), height = static_cast<int>(height_px_);
  const int stride = static_cast<int>(stride_bytes);
  unsigned char* bytes = bytes_.data();
  unsigned long size = static_cast<unsigned long>(bytes_.size());
  if (tjCompress2(compressor_.get(), pixels, width, stride, height, TJPF_GRAY, &bytes, &size, TJSAMP_GRAY,
                  quality_, TJFLAG_NOREALLOC) != 0) {
    return false;
  }
  return tjDecompress2(decompressor_.get(), bytes, size, pixels, width, stride, height, TJPF_GRAY, 0) == 0;
}

}  // namespace glint::sim
