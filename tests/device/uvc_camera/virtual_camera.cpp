// SPDX-License-Identifier: MIT
// The kernel's end of a socket pair goes to the port, the other speaks USB/IP.
#include "tests/device/uvc_camera/virtual_camera.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>

#include "host/base/error.hpp"

namespace glint::device {
namespace {

constexpr std::int64_t kMicroframe_ns = 125'000;

}  // namespace

VirtualCamera::VirtualCamera(CameraModel model, unsigned port)
    : model_(std::move(model)), port_(port), control_(model_) {}

VirtualCamera::~VirtualCamera() { unplug(); }

void VirtualCamera::plug() {
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
    throw Error(std::string("socketpair: ") + std::strerror(errno));
  control_ = ControlPipe(model_);
  received_.clear();
  hangs_ = false;
  socket_ = ends[0];
  try {
    port_.attach(ends[1]);
  } catch (...) {
    close(ends[1]);
    unplug();
    throw;
  }
  close(ends[1]);
}

void VirtualCamera::unplug() noexcept {
  if (socket_ < 0) return;
  port_.detach();
  close(socket_);
  socket_ = -1;
  transfers_.clear();
  stream_.reset();
  bus_runs_ = false;
}

void VirtualCamera::send(StreamFrame frame) {
  if (streaming()) stream_.push(std::move(frame));
}

void VirtualCamera::reply(const std::vector<std::uint8_t>& bytes) {
  std::size_t sent = 0;
  while (sent < bytes.size()) {
    const ssize_t now = ::send(socket_, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
    if (now <= 0) return;  // the host is gone; answer_host() will see it
    sent += static_cast<std::size_t>(now);
  }
}

bool VirtualCamera::answer_host(std::int64_t now_ns) {
  std::uint8_t chunk[4096];
  for (;;) {
    const ssize_t got = recv(socket_, chunk, sizeof chunk, MSG_DONTWAIT);
    if (got == 0 || (got < 0 && errno != EAGAIN && errno != EINTR)) return false;
    if (got < 0) break;
    received_.insert(received_.end(), chunk, chunk + got);
  }
  while (std::optional<UsbipRequest> request = take_request(received_)) answer(std::move(*request), now_ns);
  return true;
}

void VirtualCamera::answer(UsbipRequest request, std::int64_t now_ns) {
  if (request.command == UsbipCommand::Unlink) {
    const auto found = std::find_if(transfers_.begin(), transfers_.end(), [&](const UsbipRequest& transfer) {
      return transfer.seqnum == request.unlinked_seqnum;
    });
    const bool pending = found != transfers_.end();
    if (pending) transfers_.erase(found);
    reply(unlink_reply(request, pending ? -ECONNRESET : 0));
  } else if (request.endpoint == 0) {
    const bool streamed = streaming();
    const std::optional<std::vector<std::uint8_t>> data = control_.answer(request.setup, request.data);
    if (streamed != streaming()) {
      stream_.reset();
      bus_runs_ = false;
    }
    reply(submit_reply(request, data ? 0 : -EPIPE, data ? *data : std::vector<std::uint8_t>()));
  } else {
    const std::int64_t microframe = (now_ns + kMicroframe_ns - 1) / kMicroframe_ns * kMicroframe_ns;
    if (transfers_.empty() && bus_runs_ && microframe > bus_ns_ + kMicroframe_ns && !hangs_) ++starved_;
    if (transfers_.empty()) bus_ns_ = bus_runs_ ? std::max(bus_ns_, microframe) : microframe;
    bus_runs_ = true;
    transfers_.push_back(std::move(request));
  }
}

std::int64_t VirtualCamera::next_due_ns() const noexcept {
  if (transfers_.empty() || hangs_ || !plugged()) return std::numeric_limits<std::int64_t>::max();
  return bus_ns_ + static_cast<std::int64_t>(transfers_.front().packets.size()) * kMicroframe_ns;
}

void VirtualCamera::complete_due(std::int64_t now_ns) {
  if (hangs_) bus_ns_ = std::max(bus_ns_, now_ns);
  while (next_due_ns() <= now_ns) {
    complete(transfers_.front());
    transfers_.pop_front();
  }
}

void VirtualCamera::complete(const UsbipRequest& request) {
  std::vector<IsoPacket> packets = request.packets;
  data_.resize(static_cast<std::size_t>(std::max(request.transfer_bytes, 0)));
  std::size_t used = 0;
  for (IsoPacket& packet : packets) {
    const std::size_t room = std::min<std::size_t>(packet.length, data_.size() - used);
    if (room > PayloadStream::kHeaderBytes) {
      const PayloadStream::Packet payload = stream_.next(bus_ns_, std::span(data_).subspan(used, room));
      packet.status = payload.failed ? -EPROTO : 0;
      packet.actual_length = payload.failed ? 0 : static_cast<std::uint32_t>(payload.bytes);
      used += packet.actual_length;
    }
    bus_ns_ += kMicroframe_ns;
  }
  reply(iso_reply(request, packets, std::span(data_).first(used)));
}

}  // namespace glint::device
