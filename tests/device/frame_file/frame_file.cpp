// SPDX-License-Identifier: MIT
// Plain reads and writes; the index is made while loading.
#include "tests/device/frame_file/frame_file.hpp"

#include <cstring>
#include <iterator>
#include <string>
#include <string_view>

#include "host/base/error.hpp"

namespace glint::device {
namespace {

constexpr std::string_view kMagic = "GLNTJPG1";
constexpr std::size_t kHeaderBytes = 8 + 4 * 4 + 8;

static_assert(sizeof(FrameFileHeader) == kHeaderBytes - 8);

}  // namespace

FrameFileWriter::FrameFileWriter(std::filesystem::path path, const FrameFileHeader& header)
    : path_(std::move(path)),
      file_(path_, std::ios::binary),
      missing_((std::uint64_t{header.ticks} + 1) * header.cameras) {
  char bytes[kHeaderBytes];
  std::memcpy(bytes, kMagic.data(), 8);
  std::memcpy(bytes + 8, &header, sizeof header);
  file_.write(bytes, sizeof bytes);
  if (!file_) throw Error(path_.string() + ": cannot be written");
}

void FrameFileWriter::add(std::span<const std::uint8_t> jpeg) {
  const auto size = static_cast<std::uint32_t>(jpeg.size());
  char bytes[4];
  std::memcpy(bytes, &size, 4);
  file_.write(bytes, 4);
  file_.write(reinterpret_cast<const char*>(jpeg.data()), static_cast<std::streamsize>(jpeg.size()));
  --missing_;
}

void FrameFileWriter::finish() {
  file_.close();
  if (!file_) throw Error(path_.string() + ": cannot be written to its end");
  if (missing_ != 0) throw Error(path_.string() + ": " + std::to_string(missing_) + " frames are missing");
}

FrameFile::FrameFile(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Error(path.string() + ": cannot be read");
  bytes_.resize(std::filesystem::file_size(path));
  file.read(reinterpret_cast<char*>(bytes_.data()), static_cast<std::streamsize>(bytes_.size()));
  if (!file || bytes_.size() < kHeaderBytes || std::memcmp(bytes_.data(), kMagic.data(), 8) != 0)
    throw Error(path.string() + ": is no file of JPEG frames (sim_frames makes them)");
  std::memcpy(&header_, bytes_.data() + 8, sizeof header_);
  const std::uint64_t count = (std::uint64_t{header_.ticks} + 1) * header_.cameras;
  std::size_t at = kHeaderBytes;
  for (std::uint64_t i = 0; i < count; ++i) {
    std::uint32_t size = 0;
    if (bytes_.size() - at < 4) throw Error(path.string() + ": ends too early");
    std::memcpy(&size, bytes_.data() + at, 4);
    at += 4;
    if (bytes_.size() - at < size) throw Error(path.string() + ": ends too early");
    frames_.push_back(std::span(bytes_).subspan(at, size));
    at += size;
  }
  if (header_.cameras == 0 || header_.ticks == 0) throw Error(path.string() + ": holds no frames");
}

std::span<const std::uint8_t> FrameFile::frame(std::uint64_t tick, std::uint32_t camera) const noexcept {
  return frames_[back_and_forth(tick, header_.ticks) * header_.cameras + camera];
}

std::span<const std::uint8_t> FrameFile::dark(std::uint32_t camera) const noexcept {
  return frames_[std::uint64_t{header_.ticks} * header_.cameras + camera];
}

std::uint64_t back_and_forth(std::uint64_t tick, std::uint64_t ticks) noexcept {
  if (ticks < 2) return 0;
  const std::uint64_t turn = 2 * (ticks - 1), at = tick % turn;
  return at < ticks ? at : turn - at;
}

}  // namespace glint::device
