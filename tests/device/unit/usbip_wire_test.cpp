// SPDX-License-Identifier: MIT
// USB/IP requests and replies, byte by byte.
#include "tests/device/uvc_camera/usbip_wire.hpp"

#include <gtest/gtest.h>

namespace glint::device {
namespace {

using Bytes = std::vector<std::uint8_t>;

void put(Bytes& bytes, std::uint32_t word) {
  for (const unsigned shift : {24u, 16u, 8u, 0u}) bytes.push_back(static_cast<std::uint8_t>(word >> shift));
}

std::uint32_t word(const Bytes& bytes, std::size_t number) {
  const std::size_t at = number * 4;
  return std::uint32_t{bytes[at]} << 24 | std::uint32_t{bytes[at + 1]} << 16 |
         std::uint32_t{bytes[at + 2]} << 8 | bytes[at + 3];
}

/// A submit as the kernel sends it, without what follows the header.
Bytes submit(std::uint32_t seqnum, bool in, std::uint32_t endpoint, std::uint32_t length,
             std::uint32_t packets) {
  Bytes bytes;
  for (const std::uint32_t w : {1u, seqnum, 3u, in ? 1u : 0u, endpoint, 0u, length, 77u, packets, 1u})
    put(bytes, w);
  for (std::uint8_t i = 0; i < 8; ++i) bytes.push_back(static_cast<std::uint8_t>(0xA0 + i));
  return bytes;
}

TEST(UsbipWire, TakesRequestsOnlyWhenTheyAreWhole) {
  const Bytes header = submit(5, false, 0, 3, 0xFFFFFFFFu);
  Bytes bytes;
  for (std::size_t i = 0; i < header.size() + 3; ++i) {
    EXPECT_FALSE(take_request(bytes)) << i << " bytes of it";
    bytes.push_back(i < header.size() ? header[i] : static_cast<std::uint8_t>(i));
  }
  bytes.push_back(99);  // begin of the next
  const auto request = take_request(bytes);
  ASSERT_TRUE(request);
  EXPECT_EQ(request->seqnum, 5u);
  EXPECT_EQ(request->setup[7], 0xA7);
  EXPECT_EQ(request->data, (Bytes{48, 49, 50}));
  EXPECT_TRUE(request->packets.empty());
  EXPECT_EQ(bytes, Bytes{99});
}

TEST(UsbipWire, IsochronousRequestsCarryTheirPackets) {
  Bytes bytes = submit(6, true, 1, 6144, 2);
  for (const std::uint32_t w : {0u, 3072u, 0u, 0u, 3072u, 3072u, 0u, 0u}) put(bytes, w);
  const auto request = take_request(bytes);
  ASSERT_TRUE(request);
  ASSERT_EQ(request->packets.size(), 2u);
  EXPECT_EQ(request->packets[1].offset, 3072u);
  EXPECT_EQ(request->packets[1].length, 3072u);
  std::vector<IsoPacket> packets = request->packets;
  packets[0].actual_length = 2;
  packets[1].status = -71;
  const Bytes reply = iso_reply(*request, packets, Bytes{2, 0x80});
  ASSERT_EQ(reply.size(), 48u + 2 + 32);
  EXPECT_EQ(word(reply, 0), 3u);
  EXPECT_EQ(word(reply, 1), 6u);
  EXPECT_EQ(word(reply, 6), 2u) << "bytes in all";
  EXPECT_EQ(word(reply, 7), 77u) << "first frame";
  EXPECT_EQ(word(reply, 8), 2u) << "packets";
  EXPECT_EQ(word(reply, 9), 1u) << "packets that failed";
}

TEST(UsbipWire, ARefusalCarriesNoData) {
  Bytes bytes = submit(7, true, 0, 18, 0);
  const auto request = take_request(bytes);
  ASSERT_TRUE(request);
  const Bytes refused = submit_reply(*request, -32, Bytes{1, 2});
  ASSERT_EQ(refused.size(), 48u);
  EXPECT_EQ(word(refused, 5), 0xFFFFFFE0u);
  EXPECT_EQ(word(refused, 6), 0u);
  EXPECT_EQ(submit_reply(*request, 0, Bytes{1, 2}).size(), 50u);
}

TEST(UsbipWire, UnlinkNamesWhatItTakesBack) {
  Bytes bytes;
  for (const std::uint32_t w : {2u, 9u, 3u, 0u, 0u, 6u}) put(bytes, w);
  bytes.resize(48);
  const auto request = take_request(bytes);
  ASSERT_TRUE(request);
  EXPECT_EQ(request->unlinked_seqnum, 6u);
  const Bytes reply = unlink_reply(*request, -104);
  ASSERT_EQ(reply.size(), 48u);
  EXPECT_EQ(word(reply, 0), 4u);
  EXPECT_EQ(word(reply, 1), 9u);
  EXPECT_EQ(word(reply, 5), 0xFFFFFF98u);
}

}  // namespace
}  // namespace glint::device
