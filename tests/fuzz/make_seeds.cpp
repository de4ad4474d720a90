// SPDX-License-Identifier: MIT
// make_seeds FOLDER: writes what the fuzz programs start from, FOLDER/jpeg and FOLDER/v4l2.
#include <turbojpeg.h>

#include <array>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/fuzz/jpeg_input.hpp"
#include "tests/unit/capture/grey_jpeg.hpp"

namespace glint::test {
namespace {

namespace fs = std::filesystem;
using Bytes = std::vector<std::uint8_t>;

void write(const fs::path& file, const Bytes& bytes) {
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!out.flush()) throw std::runtime_error("cannot write " + file.string());
}

Bytes with_head(const JpegInput& how, const Bytes& jpeg) {
  Bytes bytes{how.size, how.limit, how.rise, how.gap};
  bytes.insert(bytes.end(), jpeg.begin(), jpeg.end());
  return bytes;
}

/// Every size, in the forms that cameras send.
void write_jpegs(const fs::path& folder) {
  constexpr std::array kSamplings{TJSAMP_GRAY, TJSAMP_422, TJSAMP_420, TJSAMP_444};
  unsigned count = 0;
  for (std::uint8_t size = 0; size < kJpegSizes.size(); ++size) {
    const auto [width, height] = kJpegSizes[size];
    for (const int sampling : kSamplings) {
      for (const bool restarts : {false, true}) {
        const int quality = std::array{30, 80, 95}[count % 3];
        const Bytes jpeg =
            sampled_jpeg_of(disc_picture(width, height, count), width, height, quality, sampling, restarts);
        const JpegInput how{size, static_cast<std::uint8_t>(count * 37), static_cast<std::uint8_t>(count % 3),
                            static_cast<std::uint8_t>(count)};
        write(folder / ("picture" + std::to_string(count++)), with_head(how, jpeg));
        write(folder / ("picture" + std::to_string(count++)), with_head(how, without_huffman_tables(jpeg)));
      }
    }
  }
}

/// From drivers that do no harm to those that do nothing but harm.
void write_decisions(const fs::path& folder) {
  std::mt19937 random(1);
  for (unsigned count = 0; count < 48; ++count) {
    Bytes bytes(64 + random() % 1500);
    const unsigned spoilt_percent = std::array{0u, 1u, 5u, 30u, 100u, 10u}[count % 6];
    for (std::uint8_t& byte : bytes)
      byte = random() % 100 < spoilt_percent ? static_cast<std::uint8_t>(random())
                                             : static_cast<std::uint8_t>(128 + random() % 128);
    bytes[0] = static_cast<std::uint8_t>(count);  // what is tried
    write(folder / ("decisions" + std::to_string(count)), bytes);
  }
}

}  // namespace
}  // namespace glint::test

int main(int count, char** words) {
  if (count != 2) {
    std::fprintf(stderr, "usage: make_seeds FOLDER\n");
    return 2;
  }
  try {
    const std::filesystem::path folder = words[1];
    for (const char* const name : {"jpeg", "v4l2"}) std::filesystem::create_directories(folder / name);
    glint::test::write_jpegs(folder / "jpeg");
    glint::test::write_decisions(folder / "v4l2");
  } catch (const std::exception& error) {
    std::fprintf(stderr, "make_seeds: %s\n", error.what());
    return 1;
  }
  return 0;
}
