// SPDX-License-Identifier: MIT
// Renders the simulated rig into a file of JPEG frames for the virtual cameras. `glint sim --jpeg Q` with the
// same options writes the pictures that these JPEGs decode to.
#include <turbojpeg.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/sim/scene.hpp"
#include "host/sim/sim_source.hpp"
#include "tests/device/frame_file/frame_file.hpp"
#include "tests/device/program/program.hpp"

namespace glint::device {
namespace {

struct Close {
  void operator()(void* handle) const noexcept { tjDestroy(handle); }
};

/// Grey pictures to JPEG, as host/sim does it.
class Compressor {
 public:
  explicit Compressor(int quality) : handle_(tjInitCompress()), quality_(quality) {
    if (!handle_) throw Error("libjpeg-turbo cannot be started");
  }
  std::span<const std::uint8_t> compress(const gpu::ImageView& image) {
    const int width = static_cast<int>(image.width_px), height = static_cast<int>(image.height_px);
    bytes_.resize(tjBufSize(width, height, TJSAMP_GRAY));
    unsigned char* to = bytes_.data();
    unsigned long size = static_cast<unsigned long>(bytes_.size());
    if (tjCompress2(handle_.get(), image.pixels, width, static_cast<int>(image.stride_bytes), height,
                    TJPF_GRAY, &to, &size, TJSAMP_GRAY, quality_, TJFLAG_NOREALLOC) != 0)
      throw Error("libjpeg-turbo cannot compress a frame");
    return std::span(bytes_).first(size);
  }

 private:
  std::unique_ptr<void, Close> handle_;
  int quality_;
  std::vector<std::uint8_t> bytes_;
};

void add_ticks(const SimOptions& options, std::uint32_t ticks, Compressor& jpeg, FrameFileWriter& file) {
  const Scene scene(options);
  SimSource source(scene, {false, ticks});
  FramePool pool(std::vector<FrameSize>(options.cameras, {options.width_px, options.height_px}), 1);
  FrameSet set;
  for (std::uint32_t tick = 0; tick < ticks; ++tick) {
    if (source.read(pool, set) != ReadStatus::Ok) throw Error(source.problem());
    for (std::uint32_t c = 0; c < options.cameras; ++c) file.add(jpeg.compress(set.frames[c]->image()));
  }
}

int run(int argc, char** argv) {
  SimOptions options;
  std::uint32_t ticks = 90;
  int quality = 90;
  std::string out;
  CLI::App app("renders the simulated rig into a file of JPEG frames");
  app.add_option("--out", out, "file to write")->required();
  app.add_option("--ticks", ticks, "frames per camera")->check(CLI::Range(1, 100000));
  app.add_option("--quality", quality, "of the JPEGs")->check(CLI::Range(1, 100));
  app.add_option("--cameras", options.cameras, "number of cameras");
  app.add_option("--markers", options.markers, "number of markers");
  app.add_option("--rate", options.rate_hz, "frames per second");
  app.add_option("--seed", options.seed, "same seed, same pictures");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    throw UsageError(error.what());
  }
  FrameFileWriter file(out, {options.cameras, options.width_px, options.height_px, ticks, options.rate_hz});
  Compressor jpeg(quality);
  add_ticks(options, ticks, jpeg, file);
  options.markers = 0;
  add_ticks(options, 1, jpeg, file);
  file.finish();
  return 0;
}

}  // namespace
}  // namespace glint::device

int main(int argc, char** argv) {
  return glint::device::run_program("sim_frames", glint::device::run, argc, argv);
}
