// SPDX-License-Identifier: MIT
// Writes grey frames into v4l2loopback devices at a fixed rate while a command captures them.
//   loopback_feeder [--frames FILE] [--rate HZ] [--length N] --device DEVICE... -- COMMAND ARGUMENT...
// Starts COMMAND when the devices have their format, feeds until it ends, and ends as it did.
#include <fcntl.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <time.h>
#include <turbojpeg.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "tests/device/frame_file/frame_file.hpp"
#include "tests/device/frame_file/pulse_tag.hpp"
#include "tests/device/program/program.hpp"
#include "tests/device/reader_command/reader_command.hpp"

namespace glint::device {
namespace {

constexpr std::uint32_t kWidth_px = 1280, kHeight_px = 800;
constexpr std::size_t kFrameBytes = std::size_t{kWidth_px} * kHeight_px;

/// One device that frames are written into.
class LoopbackDevice {
 public:
  explicit LoopbackDevice(const std::string& path)
      : path_(path), fd_(open(path.c_str(), O_RDWR | O_CLOEXEC)) {
    v4l2_format format{};
    format.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    format.fmt.pix.width = kWidth_px;
    format.fmt.pix.height = kHeight_px;
    format.fmt.pix.pixelformat = V4L2_PIX_FMT_GREY;
    format.fmt.pix.field = V4L2_FIELD_NONE;
    format.fmt.pix.bytesperline = kWidth_px;
    format.fmt.pix.sizeimage = kFrameBytes;
    if (fd_ < 0 || ioctl(fd_, VIDIOC_S_FMT, &format) != 0) {
      const int reason = errno;
      if (fd_ >= 0) close(fd_);
      throw Error(path_ + ": takes no grey frames: " + std::strerror(reason));
    }
  }
  LoopbackDevice(LoopbackDevice&& other) noexcept
      : path_(std::move(other.path_)), fd_(std::exchange(other.fd_, -1)) {}
  LoopbackDevice& operator=(LoopbackDevice&&) = delete;
  ~LoopbackDevice() {
    if (fd_ >= 0) close(fd_);
  }
  void write_frame(std::span<const std::uint8_t> pixels) {
    if (write(fd_, pixels.data(), pixels.size()) != static_cast<ssize_t>(pixels.size()))
      throw Error(path_ + ": a frame cannot be written: " + std::strerror(errno));
  }

 private:
  std::string path_;
  int fd_;
};

/// Pictures of each camera, decoded before the first is needed; or grey ones that differ from pulse to pulse.
class Pictures {
 public:
  Pictures(const std::string& path, std::uint32_t cameras, std::uint32_t most) : cameras_(cameras) {
    if (path.empty()) {
      ticks_ = 1;
      pixels_.assign(cameras * kFrameBytes, 8);
      return;
    }
    const FrameFile file(path);
    if (file.header().cameras < cameras || file.header().width_px != kWidth_px ||
        file.header().height_px != kHeight_px)
      throw Error(path + ": has too few cameras or another size than 1280x800");
    ticks_ = std::min(most, file.header().ticks);
    pixels_.resize(std::size_t{ticks_} * cameras * kFrameBytes);
    void* decoder = tjInitDecompress();
    for (std::uint32_t tick = 0; tick < ticks_; ++tick) {
      for (std::uint32_t c = 0; c < cameras; ++c) {
        const std::span<const std::uint8_t> jpeg = file.frame(tick, c);
        if (tjDecompress2(decoder, jpeg.data(), static_cast<unsigned long>(jpeg.size()), of(tick, c).data(),
                          kWidth_px, 0, kHeight_px, TJPF_GRAY, 0) != 0)
          throw Error(path + ": a frame cannot be decoded");
      }
    }
    tjDestroy(decoder);
  }
  std::span<std::uint8_t> of(std::uint64_t pulse, std::uint32_t camera) {
    return std::span(pixels_).subspan((back_and_forth(pulse, ticks_) * cameras_ + camera) * kFrameBytes,
                                      kFrameBytes);
  }

 private:
  std::uint32_t cameras_, ticks_ = 0;
  std::vector<std::uint8_t> pixels_;
};

int feed(std::vector<LoopbackDevice>& devices, Pictures& pictures, double rate_hz, ReaderCommand& reader) {
  timespec start{};
  clock_gettime(CLOCK_MONOTONIC, &start);
  for (std::uint64_t pulse = 0; !reader.ended(); ++pulse) {
    const auto after_ns =
        static_cast<std::int64_t>(static_cast<double>(pulse) * 1e9 / rate_hz) + start.tv_nsec;
    const timespec due{start.tv_sec + after_ns / 1000000000, after_ns % 1000000000};
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, nullptr);
    for (std::uint32_t c = 0; c < devices.size(); ++c) {
      const std::span<std::uint8_t> pixels = pictures.of(pulse, c);
      put_pulse(pixels.first<kGreyTagPixels>(), pulse);
      devices[c].write_frame(pixels);
    }
  }
  return *reader.ended();
}

int run(int argc, char** argv) {
  const std::vector<std::string> command = take_command(argc, argv);
  std::vector<std::string> paths;
  std::string frames;
  double rate_hz = 90.0;
  std::uint32_t length = 60;
  CLI::App app("writes frames into v4l2loopback devices while a command captures them");
  app.add_option("--device", paths, "such as /dev/video40")->required()->expected(1, 32);
  app.add_option("--frames", frames, "file of JPEG frames; without it, dark ones");
  app.add_option("--rate", rate_hz, "frames per second")->check(CLI::Range(0.1, 1000.0));
  app.add_option("--length", length, "most ticks of the file that are decoded");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    throw UsageError(error.what());
  }
  std::vector<LoopbackDevice> devices;
  for (const std::string& path : paths) devices.emplace_back(path);
  Pictures pictures(frames, static_cast<std::uint32_t>(devices.size()), length);
  // Readers may ask for the format only once a first frame is there.
  for (std::uint32_t c = 0; c < devices.size(); ++c) devices[c].write_frame(pictures.of(0, c));
  become_hardware();
  ReaderCommand reader(command, {});
  return feed(devices, pictures, rate_hz, reader);
}

}  // namespace
}  // namespace glint::device

int main(int argc, char** argv) {
  return glint::device::run_program("loopback_feeder", glint::device::run, argc, argv);
}
