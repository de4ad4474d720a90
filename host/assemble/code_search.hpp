// SPDX-License-Identifier: MIT
// Where in the code of dark pulses a rig is, from pictures alone.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "host/assemble/light_history.hpp"
#include "host/base/pulse_code.hpp"

namespace glint {

/// Log-likelihood of every phase of the code, added up over cameras and pulses. A camera that is a pulse off
/// speaks for the next phase; the others outvote it. Nothing is allocated after construction.
class CodeSearch {
 public:
  CodeSearch(const PulseCode& code, std::size_t cameras);

  void restart() noexcept;
  /// Returns the phase (number of a pulse in the code minus its number here, 0 .. length - 1) once it is
  /// certain: a million times likelier than all others together, those within 8 pulses left out, which only
  /// say which camera is off; and at least 7 dark pulses, four in five of those there were, are where it
  /// says, so that it is no mere best of a bad lot.
  std::optional<std::uint64_t> add(const LightEvidence& evidence) noexcept;
  /// No phase fits what 32 groups have shown: the search began anew.
  bool in_vain() const noexcept { return in_vain_; }

 private:
  std::optional<std::uint64_t> certain() const noexcept;
  bool fits(std::uint64_t phase) const noexcept;

  const PulseCode& code_;
  float share_;  // of the evidence of one camera
  std::vector<float> score_;
  std::uint64_t first_ = 0;                // pulse
  std::array<std::uint64_t, 64> darks_{};  // pulses in which some camera was dark
  std::size_t dark_count_ = 0;
  bool any_ = false, in_vain_ = false;
};

}  // namespace glint
