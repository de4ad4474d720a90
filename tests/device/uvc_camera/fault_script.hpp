// SPDX-License-Identifier: MIT
// What goes wrong, at which pulse, with which camera: a text file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <istream>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace glint::device {

enum class FaultKind : std::uint8_t {
  Never,         ///< the frame is not sent
  Twice,         ///< the frame is sent two times
  Stale,         ///< the picture of the pulse before is sent in its place
  ErrorBit,      ///< the payloads say that something went wrong
  Toggle,        ///< the frame bit is not toggled
  BrokenPacket,  ///< one packet fails on the bus
  Truncated,     ///< the JPEG ends half-way
  Corrupt,       ///< bytes in the middle of the JPEG are others
  Late,          ///< sent `amount` milliseconds late
  Hang,          ///< from here on no transfer completes
  Resume,        ///< the end of a hang
  Unplug,        ///< the cable is pulled
  Replug,        ///< and put back
  Dark,          ///< exposed without light
  Slip,          ///< from here on the picture of `amount` pulses before is sent; 0 ends it
};

struct Fault {
  FaultKind kind = FaultKind::Never;
  double amount = 0.0;
};

/// The word of a kind, as the script has it.
std::string_view word_of(FaultKind kind) noexcept;

/// Lines `PULSE CAMERA FAULT`, such as `120 3 late:8`: pulses count from 0, cameras from 1, `*` is all of
/// them; the words are never, twice, stale, error-bit, toggle, broken-packet, truncated, corrupt, late:MS,
/// hang, resume, unplug, replug, dark, slip:PULSES. What follows # is a comment.
class FaultScript {
 public:
  FaultScript() = default;
  /// `name` and the line stand in what is thrown. Throws Error.
  FaultScript(std::istream& text, const std::string& name, unsigned cameras);
  /// Throws Error.
  static FaultScript read(const std::filesystem::path& path, unsigned cameras);

  /// In the order of the script. `camera` counts from 0.
  const std::vector<Fault>& at(std::uint64_t pulse, unsigned camera) const noexcept;

 private:
  std::map<std::pair<std::uint64_t, unsigned>, std::vector<Fault>> faults_;
};

}  // namespace glint::device
