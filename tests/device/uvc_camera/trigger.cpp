// SPDX-License-Identifier: MIT
// Faults by kind.
#include "tests/device/uvc_camera/trigger.hpp"

#include <cstdio>
#include <limits>
#include <utility>

#include "host/base/error.hpp"
#include "tests/device/frame_file/pulse_tag.hpp"

namespace glint::device {
namespace {

/// Other bytes in the middle of the JPEG; no marker comes of it, and its end stays.
void spoil(std::vector<std::uint8_t>& jpeg) {
  constexpr std::size_t kSpoilt = 400;
  const std::size_t from = jpeg.size() / 2;
  for (std::size_t i = from; i < std::min(from + kSpoilt, jpeg.size() - 2); ++i)
    jpeg[i] = static_cast<std::uint8_t>((jpeg[i] ^ 0x5Au) & 0xFEu);
}

}  // namespace

Trigger::Trigger(const TriggerOptions& options, const FrameFile& frames, const FaultScript& faults,
                 Cameras& cameras)
    : options_(options),
      frames_(frames),
      faults_(faults),
      cameras_(cameras),
      slipped_(cameras.size()),
      waits_for_port_(cameras.size()) {
  log_.reserve(options.pulses * cameras.size());
}

std::int64_t Trigger::time_ns(std::uint64_t pulse) const noexcept {
  return first_ns_ + static_cast<std::int64_t>(static_cast<double>(pulse) * 1e9 / options_.rate_hz);
}

std::int64_t Trigger::next_ns() const noexcept {
  return started() && !done() ? time_ns(next_) : std::numeric_limits<std::int64_t>::max();
}

void Trigger::fire_due(std::int64_t now_ns) {
  for (; next_ns() <= now_ns; ++next_) {
    for (unsigned c = 0; c < cameras_.size(); ++c) expose(next_, time_ns(next_), c);
  }
}

void Trigger::fire(std::int64_t pulse_ns) {
  if (done()) return;
  for (unsigned c = 0; c < cameras_.size(); ++c) expose(next_, pulse_ns, c);
  ++next_;
}

void Trigger::replug_waiting() {
  for (unsigned c = 0; c < cameras_.size(); ++c) {
    if (!waits_for_port_[c] || !cameras_[c].can_plug()) continue;
    cameras_[c].plug();
    waits_for_port_[c] = false;
  }
}

void Trigger::act(const Fault& fault, unsigned camera) {
  switch (fault.kind) {
    case FaultKind::Hang:
      cameras_[camera].hang(true);
      break;
    case FaultKind::Resume:
      cameras_[camera].hang(false);
      break;
    case FaultKind::Unplug:
      cameras_[camera].unplug();
      break;
    case FaultKind::Replug:
      waits_for_port_[camera] = true;
      break;
    case FaultKind::Slip:
      slipped_[camera] = static_cast<std::uint64_t>(fault.amount);
      break;
    default:
      break;
  }
}

void Trigger::expose(std::uint64_t pulse, std::int64_t pulse_ns, unsigned camera) {
  const std::vector<Fault>& faults = faults_.at(pulse, camera);
  std::string words;
  for (const Fault& fault : faults) {
    words += (words.empty() ? "" : "+") + std::string(word_of(fault.kind));
    act(fault, camera);
  }
  log_.push_back({pulse, pulse_ns, camera, words, cameras_[camera].streaming()});
  std::uint64_t shown = pulse - std::min(pulse, slipped_[camera]);
  bool dark = false, never = false, twice = false;
  StreamFrame frame;
  frame.ready_ns = pulse_ns + options_.read_out_ns;
  for (const Fault& fault : faults) {
    if (fault.kind == FaultKind::Never) never = true;
    if (fault.kind == FaultKind::Twice) twice = true;
    if (fault.kind == FaultKind::Dark) dark = true;
    if (fault.kind == FaultKind::Stale && shown > 0) --shown;
    if (fault.kind == FaultKind::ErrorBit) frame.error_bit = true;
    if (fault.kind == FaultKind::Toggle) frame.same_toggle = true;
    if (fault.kind == FaultKind::BrokenPacket) frame.broken_packet = true;
    if (fault.kind == FaultKind::Late) frame.ready_ns += static_cast<std::int64_t>(fault.amount * 1e6);
  }
  if (never) return;
  frame.bytes = with_pulse_comment(dark ? frames_.dark(camera) : frames_.frame(shown, camera), shown);
  for (const Fault& fault : faults) {
    if (fault.kind == FaultKind::Truncated) frame.bytes.resize(frame.bytes.size() / 2);
    if (fault.kind == FaultKind::Corrupt) spoil(frame.bytes);
  }
  if (twice) cameras_[camera].send(frame);
  cameras_[camera].send(std::move(frame));
}

void Trigger::write_log(const std::filesystem::path& path) const {
  std::FILE* file = std::fopen(path.c_str(), "w");
  if (file == nullptr) throw Error(path.string() + ": cannot be written");
  std::fputs("pulse,camera,time_ns,fault,watched\n", file);
  for (const Entry& entry : log_) {
    std::fprintf(file, "%llu,%u,%lld,%s,%d\n", static_cast<unsigned long long>(entry.pulse), entry.camera + 1,
                 static_cast<long long>(entry.time_ns), entry.fault.c_str(), entry.watched);
  }
  if (std::fclose(file) != 0) throw Error(path.string() + ": cannot be written to its end");
}

}  // namespace glint::device
