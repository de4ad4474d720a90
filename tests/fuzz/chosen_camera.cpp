// SPDX-License-Identifier: MIT
// Offers and frames by choice. The last choice of all is always the ordinary one.
#include "tests/fuzz/chosen_camera.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "tests/unit/capture/grey_jpeg.hpp"

namespace glint::test {
namespace {

constexpr std::array<FrameSize, 4> kSizes{{{8, 8}, {0, 0}, {35, 21}, {64, 48}}};
constexpr std::array kRates_hz{0.0, 29.97, 1000.0, 100.0};

std::string text_of(Choices& choices) {
  std::string text(choices.below(40), ' ');
  for (char& c : text) c = static_cast<char>(choices.below(256));
  return text;
}

FakeFormat some_format(Choices& choices) {
  FakeFormat format;
  format.fourcc =
      choices.one_of(std::array<std::uint32_t, 6>{V4L2_PIX_FMT_NV12, V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_JPEG,
                                                  V4L2_PIX_FMT_H264, V4L2_PIX_FMT_MJPEG, V4L2_PIX_FMT_GREY});
  format.sizes.clear();
  for (std::uint32_t n = choices.below(4); n > 0; --n) {
    const FrameSize size = choices.one_of(kSizes);
    format.sizes.push_back({size.width_px, size.height_px, {}});
    for (std::uint32_t rates = choices.below(3); rates > 0; --rates)
      format.sizes.back().rates_hz.push_back(choices.one_of(kRates_hz));
  }
  format.stepwise = format.sizes.size() >= 2 && choices.one_in(2);
  return format;
}

FakeControl some_control(Choices& choices, std::uint32_t id) {
  FakeControl control;
  control.id = id;
  control.type = 1 + choices.below(12);
  control.name = choices.one_of(std::array<std::string, 4>{text_of(choices), "Trigger Mode", "", "Gain"});
  const auto wide = [&choices] {
    return choices.one_in(4)
               ? static_cast<std::int64_t>(std::uint64_t{choices.anything()} << 32 | choices.anything())
               : static_cast<std::int64_t>(choices.below(256)) - 20;
  };
  control.lowest = wide();
  control.highest = wide();
  control.step = wide();
  control.usual = wide();
  control.value = wide();
  for (std::uint32_t n = choices.below(4); n > 0; --n)
    control.menu.push_back(choices.one_in(3) ? text_of(choices) : "On");
  control.flags = choices.one_in(4) ? choices.anything() : 0;
  control.refusal = choices.one_in(4) ? EBUSY : 0;
  return control;
}

const std::vector<std::uint8_t>& jpeg_for(const FakeCamera& camera, std::uint64_t pulse) {
  static const std::array kPictures{
      jpeg_of(disc_picture(64, 48, 1), 64, 48, 80),
      without_huffman_tables(jpeg_of(disc_picture(64, 48, 2), 64, 48, 90, true)),
      jpeg_of(disc_picture(35, 21, 3), 35, 21, 80)};
  return camera.width_px == 35 ? kPictures[2] : kPictures[pulse % 2];
}

void fill(const FakeCamera& camera, std::uint64_t pulse, FakeFrame& frame) {
  if (camera.fourcc == V4L2_PIX_FMT_MJPEG || camera.fourcc == V4L2_PIX_FMT_JPEG) {
    frame.bytes = jpeg_for(camera, pulse);
    return;
  }
  const std::size_t row_bytes =
      std::size_t{camera.width_px} * (camera.fourcc == V4L2_PIX_FMT_YUYV ? 2 : 1) + camera.more_stride_bytes;
  frame.bytes.assign(row_bytes * camera.height_px * 3 / 2, static_cast<std::uint8_t>(pulse));
}

/// False: it does not come.
bool choose_frame(Choices& choices, FakeCamera& camera, std::uint64_t pulse, FakeFrame& frame) {
  fill(camera, pulse, frame);
  switch (choices.below(24)) {
    case 0:
      return false;
    case 1:
      frame.count = 2;
      break;
    case 2:
      frame.flags = choices.anything();
      break;
    case 3:
      frame.stamp = timeval{static_cast<long>(choices.anything()) - 5, static_cast<long>(choices.anything())};
      break;
    case 4:
      frame.bytesused = choices.anything();
      break;
    case 5:
      if (!frame.bytes.empty()) frame.bytes.resize(choices.anything() % frame.bytes.size());
      break;
    case 6:
      for (std::uint32_t n = choices.below(20); n > 0 && !frame.bytes.empty(); --n)
        frame.bytes[choices.anything() % frame.bytes.size()] = static_cast<std::uint8_t>(choices.anything());
      break;
    case 7:
      camera.plugged = !choices.one_in(3);
      break;
    case 8:
      camera.hung = choices.one_in(3);
      break;
    case 9:
      camera.next_sequence += choices.anything();
      break;
    default:
      break;
  }
  return true;
}

}  // namespace

void choose_camera(Choices& choices, FakeCamera& camera) {
  camera.formats.clear();
  for (std::uint32_t n = choices.below(3); n > 0; --n) camera.formats.push_back(some_format(choices));
  if (camera.formats.empty() || choices.one_in(2)) camera.formats.push_back(FakeFormat{});
  if (choices.one_in(3)) camera.formats.insert(camera.formats.begin(), {V4L2_PIX_FMT_MJPEG, {FakeSize{}}});
  for (std::uint32_t n = choices.below(4); n > 0; --n)
    camera.controls.push_back(some_control(choices, 100 * n + choices.below(50)));
  camera.card = choices.one_in(4) ? text_of(choices) : "Fake camera";
  camera.takes_pointers = choices.one_in(2);
  camera.sets_rate = !choices.one_in(4);
  camera.more_stride_bytes = choices.one_in(4) ? choices.below(100) : 0;
  camera.most_buffers = choices.one_in(4) ? choices.below(34) : 32;
  camera.rate_hz = choices.one_of(std::array{25.0, 240.0, 100.0});
  camera.next_sequence = choices.one_in(4) ? choices.anything() : 0;
  camera.frame = [&choices, &camera](std::uint64_t pulse, FakeFrame& frame) {
    return choose_frame(choices, camera, pulse, frame);
  };
}

CameraRequest choose_request(Choices& choices, const std::string& path) {
  CameraRequest request;
  request.name = "left";
  request.device = path;
  if (choices.one_in(3)) request.format.kind = choices.one_of(kKindsInOrder);
  request.format.size = choices.one_of(kSizes);
  request.format.rate_hz = choices.one_in(3) ? 0.0 : 100.0;
  request.pulse_rate_hz = choices.one_of(std::array{0.0, 90.0, 100.0});
  if (choices.one_in(3)) request.controls.push_back({"gain", static_cast<std::int64_t>(choices.below(256))});
  if (choices.one_in(3)) request.controls.push_back({"trigger_mode", std::string("on")});
  return request;
}

}  // namespace glint::test
