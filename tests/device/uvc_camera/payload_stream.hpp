// SPDX-License-Identifier: MIT
// Frames cut into UVC payloads, one a microframe (UVC 1.0, 2.4.3.2), with the faults that a stream can have.
#pragma once

#include <cstdint>
#include <deque>
#include <span>
#include <vector>

namespace glint::device {

/// A frame on its way out of the camera.
struct StreamFrame {
  std::vector<std::uint8_t> bytes;
  std::int64_t ready_ns = 0;   ///< not a byte leaves before
  bool error_bit = false;      ///< every payload says that something went wrong
  bool same_toggle = false;    ///< begins with the frame bit of the one before
  bool broken_packet = false;  ///< one packet in the middle fails on the bus
};

class PayloadStream {
 public:
  static constexpr std::size_t kHeaderBytes = 2;

  void push(StreamFrame frame);
  /// What is not sent yet is gone; the frame bit starts anew.
  void reset() noexcept;
  bool empty() const noexcept { return frames_.empty(); }

  struct Packet {
    std::size_t bytes = 0;  ///< 0: nothing to say in this microframe
    bool failed = false;
  };
  /// Writes the payload of the microframe that begins at `time_ns` into `room`.
  Packet next(std::int64_t time_ns, std::span<std::uint8_t> room);

 private:
  std::deque<StreamFrame> frames_;
  std::size_t sent_ = 0;  // bytes of the first frame
  bool begun_ = false;    // the first frame has its frame bit
  std::uint8_t frame_bit_ = 0;
};

}  // namespace glint::device
