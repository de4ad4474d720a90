// SPDX-License-Identifier: MIT
// USB/IP as it goes over the wire (Documentation/usb/usbip_protocol.rst of Linux): requests in, replies out.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace glint::device {

struct IsoPacket {
  std::uint32_t offset = 0, length = 0, actual_length = 0;
  std::int32_t status = 0;  ///< 0 or minus an errno
};

enum class UsbipCommand : std::uint32_t { Submit = 1, Unlink = 2, SubmitReply = 3, UnlinkReply = 4 };

/// One request of the host, whole.
struct UsbipRequest {
  UsbipCommand command = UsbipCommand::Submit;
  std::uint32_t seqnum = 0;
  bool in = false;
  std::uint32_t endpoint = 0;
  std::int32_t transfer_bytes = 0, start_frame = 0;
  std::array<std::uint8_t, 8> setup{};
  std::vector<std::uint8_t> data;     ///< of OUT transfers
  std::vector<IsoPacket> packets;     ///< of isochronous transfers
  std::uint32_t unlinked_seqnum = 0;  ///< of Unlink
};

/// Takes the first whole request off the front of `bytes`; nothing while it is not all there.
std::optional<UsbipRequest> take_request(std::vector<std::uint8_t>& bytes);

/// Reply to a control, bulk or interrupt transfer. `data` goes along for IN transfers only.
std::vector<std::uint8_t> submit_reply(const UsbipRequest& request, std::int32_t status,
                                       std::span<const std::uint8_t> data);
/// Reply to an isochronous IN transfer: `data` holds what the packets carry, one after the other.
std::vector<std::uint8_t> iso_reply(const UsbipRequest& request, std::span<const IsoPacket> packets,
                                    std::span<const std::uint8_t> data);
std::vector<std::uint8_t> unlink_reply(const UsbipRequest& request, std::int32_t status);

}  // namespace glint::device
