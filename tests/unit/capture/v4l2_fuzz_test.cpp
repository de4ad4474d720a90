// SPDX-License-Identifier: MIT
// Drivers that answer at random: nothing crashes, hangs, leaks a slot or reads where it must not.
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstdlib>
#include <random>

#include "tests/unit/capture/camera_stream_fixture.hpp"
#include "tests/unit/capture/grey_jpeg.hpp"
#include "tests/unit/capture/spoilt_calls.hpp"

namespace glint {
namespace {

class RandomChoices final : public test::Choices {
 public:
  explicit RandomChoices(unsigned seed) : random_(seed) {}
  std::uint32_t below(std::uint32_t count) override { return anything() % count; }
  std::uint32_t anything() override { return static_cast<std::uint32_t>(random_()); }

 private:
  std::mt19937 random_;
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
    RandomChoices choices(seed);
    test::SpoiltCalls calls(fixture.driver_, choices, choices.one_of(std::array{1u, 5u, 38u, 128u}));
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
