// SPDX-License-Identifier: MIT
// Captures from several V4L2 devices at once and writes down what each buffer said.
//   v4l2_capture --csv FILE [--format MJPG|GREY] [--rate HZ] [--frames N] [--silence-ms T] [--reopen]
//   DEVICE...
// Ends when every device gave N frames, or none gave anything for T ms. CSV, a line per buffer or event:
//   camera,event,time_us,pulse,sequence,stamp_us,bytes,error,whole,spoilt
// event: frame, or stall and the errno's name. Cameras count from 1. spoilt: libjpeg-turbo warned or failed.
#include <linux/videodev2.h>
#include <poll.h>
#include <time.h>
#include <turbojpeg.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "tests/device/frame_file/pulse_tag.hpp"
#include "tests/device/program/program.hpp"
#include "tests/device/v4l2_capture/capture_device.hpp"

namespace glint::device {
namespace {

struct Arguments {
  std::vector<std::string> devices;
  std::string csv, format = "MJPG";
  std::uint32_t rate_hz = 0, frames = 0, buffers = 8, silence_ms = 1000;
  bool reopen = false, decode = false;
};

std::int64_t now_us() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return std::int64_t{now.tv_sec} * 1000000 + now.tv_nsec / 1000;
}

struct Line {
  std::size_t camera = 0;
  const char* event = "frame";
  std::int64_t time_us = 0, stamp_us = 0;
  std::uint64_t pulse = 0;
  std::uint32_t sequence = 0;
  std::size_t bytes = 0;
  bool error = false, whole = true, spoilt = false;
  std::vector<std::uint8_t> jpeg{};  ///< kept for judging after the capture
};

/// Whether libjpeg-turbo finds fault with a JPEG.
class JpegJudge {
 public:
  JpegJudge() : handle_(tjInitDecompress()) {}
  bool spoilt(std::span<const std::uint8_t> jpeg, const CaptureFormat& format) {
    pixels_.resize(std::size_t{format.width_px} * format.height_px);
    return tjDecompress2(handle_.get(), jpeg.data(), static_cast<unsigned long>(jpeg.size()), pixels_.data(),
                         static_cast<int>(format.width_px), 0, static_cast<int>(format.height_px), TJPF_GRAY,
                         0) != 0;
  }

 private:
  struct Close {
    void operator()(void* handle) const noexcept { tjDestroy(handle); }
  };
  std::unique_ptr<void, Close> handle_;
  std::vector<std::uint8_t> pixels_;
};

class Capture {
 public:
  explicit Capture(const Arguments& arguments) : arguments_(arguments) {
    const char* f = arguments.format.c_str();
    format_.fourcc = v4l2_fourcc(f[0], f[1], f[2], f[3]);
    format_.rate_hz = arguments.rate_hz;
    for (const std::string& path : arguments.devices) {
      cameras_.emplace_back().emplace(path, format_, arguments.buffers);
    }
    frames_.resize(cameras_.size());
    lines_.reserve(std::size_t{1} << 18);
  }

  void run() {
    last_sign_us_ = now_us();
    std::vector<pollfd> polls(cameras_.size());
    while (!done()) {
      for (std::size_t c = 0; c < cameras_.size(); ++c)
        polls[c] = {cameras_[c] ? cameras_[c]->fd() : -1, POLLIN, 0};
      poll(polls.data(), polls.size(), kPatience_ms);
      for (std::size_t c = 0; c < cameras_.size(); ++c) {
        if (cameras_[c] && polls[c].revents != 0) drain(c);
        if (!cameras_[c] && arguments_.reopen) try_again(c);
      }
    }
  }

  /// Afterwards: the time of the capture belongs to the cameras.
  void judge_jpegs() {
    JpegJudge judge;
    for (Line& line : lines_) {
      if (!line.jpeg.empty()) line.spoilt = judge.spoilt(line.jpeg, format_);
    }
  }

  void write_csv() const {
    std::FILE* file = std::fopen(arguments_.csv.c_str(), "w");
    if (file == nullptr) throw Error(arguments_.csv + ": cannot be written");
    std::fputs("camera,event,time_us,pulse,sequence,stamp_us,bytes,error,whole,spoilt\n", file);
    for (const Line& line : lines_) {
      std::fprintf(file, "%zu,%s,%lld,%lld,%u,%lld,%zu,%d,%d,%d\n", line.camera + 1, line.event,
                   static_cast<long long>(line.time_us), static_cast<long long>(line.pulse), line.sequence,
                   static_cast<long long>(line.stamp_us), line.bytes, line.error, line.whole, line.spoilt);
    }
    if (std::fclose(file) != 0) throw Error(arguments_.csv + ": cannot be written to its end");
  }

 private:
  static constexpr int kPatience_ms = 20;

  bool done() const {
    const bool all =
        std::all_of(frames_.begin(), frames_.end(), [&](std::uint32_t n) { return n >= arguments_.frames; });
    return (arguments_.frames != 0 && all) || now_us() - last_sign_us_ > arguments_.silence_ms * 1000LL;
  }

  void drain(std::size_t c) {
    while (const std::optional<CapturedBuffer> buffer = cameras_[c]->take()) {
      last_sign_us_ = now_us();
      note(c, *buffer);
      ++frames_[c];
      if (!cameras_[c]->give_back(*buffer)) lines_.push_back({c, "QBUF failed", now_us()});
    }
    if (cameras_[c]->problem() == 0) return;
    lines_.push_back({c, strerrorname_np(cameras_[c]->problem()), now_us()});
    last_sign_us_ = now_us();
    cameras_[c].reset();
  }

  void note(std::size_t c, const CapturedBuffer& buffer) {
    Line line{c, "frame", last_sign_us_, buffer.stamp_us};
    line.sequence = buffer.sequence;
    line.bytes = buffer.data.size();
    line.error = (buffer.flags & V4L2_BUF_FLAG_ERROR) != 0;
    if (format_.fourcc == V4L2_PIX_FMT_MJPEG) {
      line.pulse = pulse_of_comment(buffer.data).value_or(kNoPulse);
      line.whole = ends_whole(buffer.data);
      if (arguments_.decode) line.jpeg.assign(buffer.data.begin(), buffer.data.end());
    } else {
      line.whole = line.bytes == std::size_t{format_.width_px} * format_.height_px;
      line.pulse = line.whole ? get_pulse(buffer.data.first<kGreyTagPixels>()) : kNoPulse;
    }
    lines_.push_back(std::move(line));
  }

  void try_again(std::size_t c) {
    try {
      cameras_[c].emplace(arguments_.devices[c], format_, arguments_.buffers);
      lines_.push_back({c, "reopened", now_us()});
      last_sign_us_ = now_us();
    } catch (const Error&) {  // not back yet
    }
  }

  static constexpr std::uint64_t kNoPulse = ~std::uint64_t{0};
  const Arguments& arguments_;
  CaptureFormat format_;
  std::vector<std::optional<CaptureDevice>> cameras_;
  std::vector<std::uint32_t> frames_;
  std::vector<Line> lines_;
  std::int64_t last_sign_us_ = 0;
};

int run(int argc, char** argv) {
  Arguments a;
  CLI::App app("captures from V4L2 devices and writes down what each buffer said");
  app.add_option("devices", a.devices, "such as /dev/video0")->required();
  app.add_option("--csv", a.csv, "file to write")->required();
  app.add_option("--format", a.format, "MJPG or GREY")->check(CLI::IsMember({"MJPG", "GREY"}));
  app.add_option("--rate", a.rate_hz, "frames per second; 0: as it stands");
  app.add_option("--frames", a.frames, "of each device; 0: until silence");
  app.add_option("--buffers", a.buffers, "of each device");
  app.add_option("--silence-ms", a.silence_ms, "end when no device gives anything for so long");
  app.add_flag("--reopen", a.reopen, "open a lost device again when it comes back");
  app.add_flag("--decode", a.decode, "decode each JPEG at the end");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    throw UsageError(error.what());
  }
  Capture capture(a);
  capture.run();
  capture.judge_jpegs();
  capture.write_csv();
  return 0;
}

}  // namespace
}  // namespace glint::device

int main(int argc, char** argv) {
  return glint::device::run_program("v4l2_capture", glint::device::run, argc, argv);
}
