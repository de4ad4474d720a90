// SPDX-License-Identifier: MIT
// Drivers that answer at random: nothing crashes, hangs, leaks a slot or reads where it must not.
#include <gtest/gtest.h>
#include <poll.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <random>

#include "tests/unit/capture/camera_stream_fixture.hpp"
#include "tests/unit/capture/grey_jpeg.hpp"

namespace glint {
namespace {

/// Passes calls on to a driver that behaves, and spoils some of the answers.
class RandomCalls final : public DeviceCalls {
 public:
  RandomCalls(test::FakeV4l2& driver, unsigned seed) : driver_(driver), random_(seed) {
    spoilt_per_mille_ = std::array{2u, 20u, 150u, 500u}[random_() % 4];
  }

  int open(const char* path) noexcept override { return spoil() ? some_error() : driver_.open(path); }
  void close(int descriptor) noexcept override { driver_.close(descriptor); }
  std::byte* map(int descriptor, std::size_t bytes, std::int64_t offset) noexcept override {
    return spoil() ? nullptr : driver_.map(descriptor, bytes, offset);
  }
  void unmap(std::byte* memory, std::size_t bytes) noexcept override { driver_.unmap(memory, bytes); }
  int poll(int descriptor, std::chrono::nanoseconds longest) noexcept override {
    const int events = driver_.poll(descriptor, longest);
    return spoil() ? static_cast<int>(random_() % 0x40) - 4 : events;
  }
  Timestamp now() noexcept override { return driver_.now(); }

  int ioctl(int descriptor, unsigned long request, void* argument) noexcept override {
    if (!spoil()) return driver_.ioctl(descriptor, request, argument);
    if (random_() % 3 == 0) return some_error();
    const int result = driver_.ioctl(descriptor, request, argument);
    // A driver may say anything about a buffer, but where its memory is and how long is the kernel's word.
    if (request == VIDIOC_QUERYBUF || request == VIDIOC_REQBUFS || request == VIDIOC_G_EXT_CTRLS ||
        request == VIDIOC_S_EXT_CTRLS)
      return result;
    if (request == VIDIOC_DQBUF) {
      spoil_buffer(*static_cast<v4l2_buffer*>(argument));
    } else {
      auto* const bytes = static_cast<unsigned char*>(argument);
      const std::size_t size = _IOC_SIZE(request);
      for (unsigned n = 0; n < 1 + random_() % 6; ++n) bytes[random_() % size] = some_byte();
    }
    return random_() % 8 == 0 ? 0 : result;
  }

 private:
  bool spoil() { return random_() % 1000 < spoilt_per_mille_; }
  unsigned char some_byte() {
    return std::array<unsigned char, 4>{0, 0xff, 0x7f, static_cast<unsigned char>(random_())}[random_() % 4];
  }
  int some_error() {
    return -std::array{
        EIO, EINVAL, ENODEV, EAGAIN, EBUSY, ENOTTY, ENOMEM, EPIPE, ENOSPC, EACCES}[random_() % 10];
  }
  void spoil_buffer(v4l2_buffer& buffer) {
    const std::uint32_t anything = static_cast<std::uint32_t>(random_());
    switch (random_() % 6) {
      case 0:
        buffer.index = anything % 2 == 0 ? anything : anything % 8;
        break;
      case 1:
        buffer.bytesused = anything % 2 == 0 ? anything : anything % 8000;
        break;
      case 2:
        buffer.flags = anything;
        break;
      case 3:
        buffer.sequence = anything;
        break;
      case 4:
        buffer.timestamp.tv_sec = static_cast<long>(std::uint64_t{random_()} << 32 | random_());
        break;
      default:
        buffer.timestamp.tv_usec = static_cast<long>(std::uint64_t{random_()} << 32 | random_());
    }
  }

  test::FakeV4l2& driver_;
  std::mt19937 random_;
  unsigned spoilt_per_mille_;
};

void prepare(test::FakeCamera& camera, unsigned seed) {
  std::mt19937 random(seed);
  const auto jpeg = test::jpeg_of(test::disc_picture(64, 48, seed), 64, 48, 80, seed % 2 == 0);
  camera.takes_pointers = random() % 2 == 0;
  camera.most_buffers = 1 + random() % 8;
  if (seed % 3 == 0) {
    camera.formats = {{V4L2_PIX_FMT_MJPEG, {test::FakeSize{}}}};
    camera.frame = [jpeg, random](std::uint64_t, test::FakeFrame& frame) mutable {
      frame.bytes = jpeg;
      for (unsigned n = 0; n < random() % 4; ++n)
        frame.bytes[random() % jpeg.size()] = static_cast<std::uint8_t>(random());
      if (random() % 8 == 0) frame.bytes.resize(random() % jpeg.size());
      return random() % 20 != 0;
    };
  }
  camera.controls = {{10, V4L2_CTRL_TYPE_INTEGER, "Gain", 0, 255, 1, 40, 40, {}, 0, 0, 0},
                     {40, V4L2_CTRL_TYPE_MENU, "Trigger Mode", 0, 2, 1, 0, 0, {"Off", "", "On"}, 0, 0, 0}};
}

constexpr unsigned kSeeds = 600;

/// GLINT_FUZZ_SECONDS goes on for so long.
TEST(V4l2Fuzz, NoAnswerOfADriverDoesHarm) {
  const char* const more = std::getenv("GLINT_FUZZ_SECONDS");
  const auto until =
      std::chrono::steady_clock::now() + std::chrono::seconds(more == nullptr ? 0 : std::atoi(more));
  unsigned seed = 0;
  std::uint64_t frames = 0, ended = 0, refused = 0;
  for (; seed < kSeeds || std::chrono::steady_clock::now() < until; ++seed) {
    test::StreamFixture fixture;
    prepare(fixture.camera(), seed);
    RandomCalls calls(fixture.driver_, seed);
    CameraRequest request = fixture.request();
    if (seed % 5 == 0) request.format = {};
    request.controls = {{"gain", 7}, {"trigger_mode", std::string("on")}};
    try {
      CameraStream stream(calls, fixture.roots(), request);
      FramePool pool({stream.format().size}, 12);
      stream.start(pool, CameraId{0});
      ReceivedFrame received;
      for (int n = 0; n < 60; ++n) {
        const StreamStatus status = stream.next(received, std::chrono::milliseconds(15));
        if (status == StreamStatus::Frame) {
          ++frames;
          ASSERT_EQ(received.frame.damaged, received.frame.image().pixels == nullptr);
        } else if (status != StreamStatus::Nothing) {
          ++ended;
          break;
        }
      }
      stream.stop();
    } catch (const Error& error) {
      ++refused;
      ASSERT_FALSE(std::string(error.what()).empty());
    }
    {
      DeviceNode node(calls, fixture.path_.c_str());
      ASSERT_FALSE(describe(list_formats(node)).empty());
      (void)list_controls(node);
    }
    ASSERT_EQ(fixture.driver_.open_nodes(), 0) << seed;
    ASSERT_EQ(fixture.driver_.mappings(), 0) << seed;
  }
  std::printf("%u drivers: %llu frames, %llu streams ended by the driver, %llu not opened\n", seed,
              static_cast<unsigned long long>(frames), static_cast<unsigned long long>(ended),
              static_cast<unsigned long long>(refused));
  EXPECT_GT(frames, 1000u) << "the test reaches nothing";
  EXPECT_GT(ended, 20u);
  EXPECT_GT(refused, 20u);
}

}  // namespace
}  // namespace glint
