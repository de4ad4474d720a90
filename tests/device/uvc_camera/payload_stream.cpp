// SPDX-License-Identifier: MIT
// Header of two bytes: its length, and the bits end of header, error, end of frame, frame.
#include "tests/device/uvc_camera/payload_stream.hpp"

#include <algorithm>
#include <cstring>
#include <utility>

namespace glint::device {
namespace {

enum : std::uint8_t { kFrameBit = 0x01, kEndOfFrame = 0x02, kError = 0x40, kEndOfHeader = 0x80 };

}  // namespace

void PayloadStream::push(StreamFrame frame) { frames_.push_back(std::move(frame)); }

void PayloadStream::reset() noexcept {
  frames_.clear();
  sent_ = 0;
  begun_ = false;
  frame_bit_ = 0;
}

PayloadStream::Packet PayloadStream::next(std::int64_t time_ns, std::span<std::uint8_t> room) {
  if (frames_.empty() || frames_.front().ready_ns > time_ns) return {};
  const StreamFrame& frame = frames_.front();
  if (!begun_) {
    begun_ = true;
    if (!frame.same_toggle) frame_bit_ ^= kFrameBit;
  }
  const std::size_t left = frame.bytes.size() - sent_;
  const std::size_t now = std::min(left, room.size() - kHeaderBytes);
  const std::size_t middle = frame.bytes.size() / 2;
  Packet packet{kHeaderBytes + now, false};
  packet.failed = frame.broken_packet && sent_ <= middle && middle < sent_ + now;
  room[0] = kHeaderBytes;
  room[1] = static_cast<std::uint8_t>(kEndOfHeader | frame_bit_ | (frame.error_bit ? kError : 0) |
                                      (now == left ? kEndOfFrame : 0));
  std::memcpy(room.data() + kHeaderBytes, frame.bytes.data() + sent_, now);
  sent_ += now;
  if (now == left) {
    frames_.pop_front();
    sent_ = 0;
    begun_ = false;
  }
  return packet;
}

}  // namespace glint::device
