// SPDX-License-Identifier: MIT
// Big-endian words: a header of 48 bytes, then data, then packet descriptors.
#include "tests/device/uvc_camera/usbip_wire.hpp"

#include <algorithm>

namespace glint::device {
namespace {

constexpr std::size_t kHeaderBytes = 48, kPacketBytes = 16;

std::uint32_t word_at(const std::vector<std::uint8_t>& bytes, std::size_t at) {
  return std::uint32_t{bytes[at]} << 24 | std::uint32_t{bytes[at + 1]} << 16 |
         std::uint32_t{bytes[at + 2]} << 8 | bytes[at + 3];
}

void put_word(std::vector<std::uint8_t>& bytes, std::uint32_t word) {
  for (const unsigned shift : {24u, 16u, 8u, 0u}) bytes.push_back(static_cast<std::uint8_t>(word >> shift));
}

std::vector<std::uint8_t> reply(UsbipCommand command, std::uint32_t seqnum, std::int32_t status,
                                std::size_t actual_bytes, std::int32_t start_frame, std::size_t packets,
                                std::size_t errors) {
  std::vector<std::uint8_t> bytes;
  bytes.reserve(kHeaderBytes + actual_bytes + packets * kPacketBytes);
  put_word(bytes, static_cast<std::uint32_t>(command));
  put_word(bytes, seqnum);
  for (int unused = 0; unused < 3; ++unused) put_word(bytes, 0);  // device, direction, endpoint
  put_word(bytes, static_cast<std::uint32_t>(status));
  put_word(bytes, static_cast<std::uint32_t>(actual_bytes));
  put_word(bytes, static_cast<std::uint32_t>(start_frame));
  put_word(bytes, static_cast<std::uint32_t>(packets));
  put_word(bytes, static_cast<std::uint32_t>(errors));
  bytes.resize(kHeaderBytes);
  return bytes;
}

}  // namespace

std::optional<UsbipRequest> take_request(std::vector<std::uint8_t>& bytes) {
  if (bytes.size() < kHeaderBytes) return std::nullopt;
  UsbipRequest request;
  request.command = static_cast<UsbipCommand>(word_at(bytes, 0));
  request.seqnum = word_at(bytes, 4);
  request.in = word_at(bytes, 12) != 0;
  request.endpoint = word_at(bytes, 16);
  std::size_t data_bytes = 0, packets = 0;
  if (request.command == UsbipCommand::Unlink) {
    request.unlinked_seqnum = word_at(bytes, 20);
  } else {
    request.transfer_bytes = static_cast<std::int32_t>(word_at(bytes, 24));
    request.start_frame = static_cast<std::int32_t>(word_at(bytes, 28));
    const auto count = static_cast<std::int32_t>(word_at(bytes, 32));  // -1 where it means nothing
    packets = static_cast<std::size_t>(std::max(count, 0));
    std::copy_n(bytes.begin() + 40, 8, request.setup.begin());
    data_bytes = request.in ? 0 : static_cast<std::size_t>(request.transfer_bytes);
  }
  const std::size_t whole = kHeaderBytes + data_bytes + packets * kPacketBytes;
  if (bytes.size() < whole) return std::nullopt;
  const auto data = bytes.begin() + kHeaderBytes;
  request.data.assign(data, data + static_cast<std::ptrdiff_t>(data_bytes));
  for (std::size_t at = kHeaderBytes + data_bytes; at < whole; at += kPacketBytes) {
    request.packets.push_back({word_at(bytes, at), word_at(bytes, at + 4), 0, 0});
  }
  bytes.erase(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(whole));
  return request;
}

std::vector<std::uint8_t> submit_reply(const UsbipRequest& request, std::int32_t status,
                                       std::span<const std::uint8_t> data) {
  const std::size_t actual = request.in ? data.size() : static_cast<std::size_t>(request.transfer_bytes);
  std::vector<std::uint8_t> bytes =
      reply(UsbipCommand::SubmitReply, request.seqnum, status, status == 0 ? actual : 0, 0, 0, 0);
  if (request.in && status == 0) bytes.insert(bytes.end(), data.begin(), data.end());
  return bytes;
}

std::vector<std::uint8_t> iso_reply(const UsbipRequest& request, std::span<const IsoPacket> packets,
                                    std::span<const std::uint8_t> data) {
  const auto errors = static_cast<std::size_t>(
      std::count_if(packets.begin(), packets.end(), [](const IsoPacket& p) { return p.status != 0; }));
  std::vector<std::uint8_t> bytes = reply(UsbipCommand::SubmitReply, request.seqnum, 0, data.size(),
                                          request.start_frame, packets.size(), errors);
  bytes.insert(bytes.end(), data.begin(), data.end());
  for (const IsoPacket& packet : packets) {
    put_word(bytes, packet.offset);
    put_word(bytes, packet.length);
    put_word(bytes, packet.actual_length);
    put_word(bytes, static_cast<std::uint32_t>(packet.status));
  }
  return bytes;
}

std::vector<std::uint8_t> unlink_reply(const UsbipRequest& request, std::int32_t status) {
  return reply(UsbipCommand::UnlinkReply, request.seqnum, status, 0, 0, 0, 0);
}

}  // namespace glint::device
