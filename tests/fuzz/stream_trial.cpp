// SPDX-License-Identifier: MIT
// Streams and the pairing of their frames, all in one thread.
#include <algorithm>
#include <chrono>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string_view>
#include <vector>

#include "host/assemble/assembler.hpp"
#include "host/base/check.hpp"
#include "host/base/error.hpp"
#include "host/capture/v4l2/camera_stream.hpp"
#include "tests/fuzz/chosen_camera.hpp"
#include "tests/fuzz/v4l2_trials.hpp"
#include "tests/unit/capture/spoilt_calls.hpp"

namespace glint::test {
namespace {

constexpr std::chrono::milliseconds kLongest{15};
constexpr std::chrono::seconds kFarthestStamp{10};
constexpr std::size_t kMostHeld = 3;
constexpr int kRounds = 50;
constexpr unsigned kMostOpenings = 3;             // again, of one camera; they take longest
constexpr std::uint64_t kMostPixels = 1'000'000;  // more only takes longer

/// A frame that a reader keeps while the camera goes on.
struct Held {
  Frame frame;
  std::size_t sum;
};

std::size_t sum_of(Frame& frame) {
  const auto pixels = frame.pixels();
  return std::hash<std::string_view>()({reinterpret_cast<const char*>(pixels.data()), pixels.size()});
}

class Streams {
 public:
  explicit Streams(ByteChoices& choices) : choices_(choices), calls_(driver_, choices, kSpoilt) {
    for (std::size_t n = 1 + choices.below(3); n > 0; --n) {
      const std::string& path = node_path(n - 1);
      choose_camera(choices, driver_.add(path));
      const CameraRequest request = choose_request(choices, path);
      try {
        auto stream = std::make_unique<CameraStream>(calls_, DeviceRoots{"/nowhere", "/nowhere"}, request);
        const FrameSize size = stream->format().size;
        if (std::uint64_t{size.width_px} * size.height_px > kMostPixels) continue;
        sizes_.push_back(size);
        cameras_.push_back({request, std::move(stream), 0});
      } catch (const Error& error) {
        GLINT_CHECK(error.what()[0] != '\0');
      }
    }
  }

  void run() {
    if (cameras_.empty()) return;
    slots_ = 1 + choices_.below(16);
    pool_ = std::make_unique<FramePool>(sizes_, slots_);
    if (choices_.one_in(2)) {
      AssembleOptions options;
      options.rate_hz = 100.0;
      options.most_sets_waiting = 2 + choices_.below(8);
      assembler_ = std::make_unique<Assembler>(cameras_.size(), options);
    }
    for (std::size_t n = 0; n < cameras_.size(); ++n) start(n);
    for (int round = 0; round < kRounds; ++round) {
      for (std::size_t n = 0; n < cameras_.size(); ++n) step(n);
      if (assembler_) pair(driver_.now());
    }
    end();
  }

  ~Streams() {
    cameras_.clear();
    GLINT_CHECK(driver_.open_nodes() == 0 && driver_.mappings() == 0);
  }
  Streams(const Streams&) = delete;
  Streams& operator=(const Streams&) = delete;

 private:
  struct Camera {
    CameraRequest request;
    std::unique_ptr<CameraStream> stream;  // none while it cannot be opened
    unsigned openings = 0;
  };
  static CameraId id(std::size_t camera) { return CameraId{static_cast<std::uint8_t>(camera)}; }

  void start(std::size_t n) {
    try {
      if (choices_.one_in(2)) {
        const FrameSize size = sizes_[n];
        cameras_[n].stream->set_limit(
            std::vector<std::uint8_t>(std::size_t{size.width_px} * size.height_px, 40));
      }
      cameras_[n].stream->start(*pool_, id(n));
    } catch (const Error& error) {
      GLINT_CHECK(error.what()[0] != '\0');
      cameras_[n].stream.reset();
    }
  }

  /// As a camera's thread does it when the camera has gone: one attempt.
  void reopen(std::size_t n) {
    if (cameras_[n].openings++ >= kMostOpenings) return;
    CameraRequest request = cameras_[n].request;
    request.format.size = sizes_[n];
    driver_.with(request.device, [](FakeCamera& camera) { camera.plugged = true; });
    try {
      cameras_[n].stream =
          std::make_unique<CameraStream>(calls_, DeviceRoots{"/nowhere", "/nowhere"}, request);
    } catch (const Error&) {
      return;
    }
    start(n);
  }

  void step(std::size_t n) {
    if (!cameras_[n].stream) return reopen(n);
    CameraStream& stream = *cameras_[n].stream;
    const std::uint64_t calls_before = calls_.calls();
    const Timestamp before = driver_.now();
    const StreamStatus status = stream.next(received_, kLongest);
    GLINT_CHECK(calls_.calls() - calls_before <= stream.buffers() + 3);
    GLINT_CHECK(driver_.now() - before <= kLongest);
    if (status == StreamStatus::Frame) {
      receive(n);
      return;
    }
    GLINT_CHECK(received_.frame.image().pixels == nullptr);
    if (assembler_ && (status != StreamStatus::Nothing || stream.silent()))
      assembler_->set_present(id(n), false);
    if (status == StreamStatus::Broken) GLINT_CHECK(!stream.problem().empty());
    if (status != StreamStatus::Nothing) cameras_[n].stream.reset();
  }

  void receive(std::size_t n) {
    Frame& frame = received_.frame;
    GLINT_CHECK(frame.damaged == (frame.image().pixels == nullptr));
    GLINT_CHECK(frame.damaged == (received_.flaw != FrameFlaw::None));
    GLINT_CHECK(frame.stamped - received_.arrived <= kFarthestStamp &&
                received_.arrived - frame.stamped <= kFarthestStamp);
    GLINT_CHECK(frame.camera == id(n) && received_.arrived == driver_.now());
    if (assembler_) {
      if (received_.flaw == FrameFlaw::NoSlot || received_.flaw == FrameFlaw::TooOld) return;
      assembler_->set_present(id(n), true);
      assembler_->add(std::move(frame), received_.arrived);
      ++added_;
      GLINT_CHECK(assembler_->ledger().balanced());
      return;
    }
    if (frame.damaged) return;
    held_.push_back({std::move(frame), 0});
    held_.back().sum = sum_of(held_.back().frame);
    if (held_.size() <= kMostHeld) return;
    Held& oldest = held_.front();
    GLINT_CHECK(calls_.wrong_buffer() || sum_of(oldest.frame) == oldest.sum);
    held_.pop_front();
  }

  void pair(Timestamp now) {
    while (assembler_->next(set_, now)) {
      GLINT_CHECK(assembler_->ledger().balanced());
      for (const std::optional<Frame>& frame : set_.frames)
        GLINT_CHECK(!frame || (frame->image().pixels != nullptr && !frame->damaged));
    }
    GLINT_CHECK(assembler_->ledger().balanced());
  }

  /// Every frame was counted, and every slot is free.
  void end() {
    if (assembler_) {
      pair(driver_.now() + std::chrono::seconds(60));
      std::uint64_t counted = 0;
      for (const CameraLedger& camera : assembler_->ledger().cameras) {
        counted += camera.total() - camera[FrameFate::LostByHost] - camera[FrameFate::LostByCamera] +
                   camera.duplicates + camera.unplaced + camera.warm_up;
      }
      GLINT_CHECK(counted == added_);
      assembler_.reset();
    }
    set_ = {};
    held_.clear();
    received_ = {};
    for (std::size_t n = 0; n < cameras_.size(); ++n) {
      if (cameras_[n].stream) cameras_[n].stream->stop();
      GLINT_CHECK(all_slots_free(*pool_, id(n), slots_));
    }
  }

  ByteChoices& choices_;
  FakeV4l2 driver_;
  SpoiltCalls calls_;
  std::vector<FrameSize> sizes_;
  std::uint32_t slots_ = 0;
  std::unique_ptr<FramePool> pool_;
  std::unique_ptr<Assembler> assembler_;  // these hold frames of the pool
  FrameSet set_;
  ReceivedFrame received_;
  std::deque<Held> held_;
  std::vector<Camera> cameras_;
  std::uint64_t added_ = 0;
};

}  // namespace

void try_streams(ByteChoices& choices) { Streams(choices).run(); }

}  // namespace glint::test
