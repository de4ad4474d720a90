// SPDX-License-Identifier: MIT
// By how many whole pulses each camera is off, from the pictures of coded pulses.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "host/assemble/code_search.hpp"
#include "host/assemble/light_history.hpp"
#include "host/base/ids.hpp"
#include "host/base/pulse_code.hpp"

namespace glint {

/// What one camera showed of one pulse.
struct SeenLight {
  bool frame = false;  ///< it had a frame; the rest is valid only then
  std::uint32_t blobs = 0;
  std::uint32_t run = 0;  ///< Frame::run
  int shifted = 0;        ///< Frame::shifted
};

/// What happened, for the person at the terminal.
struct AlignmentEvent {
  enum class Kind : std::uint8_t {
    PhaseFound,    ///< the light is coded as expected; from now on cameras can be proven
    NoPhase,       ///< so far it is not: another seed or group, no code at all, or too few markers in sight
    PhaseLost,     ///< it no longer is; the search begins anew
    SlipFound,     ///< `camera` was `pulses` behind (ahead if negative): its correction is on its way
    SlipCorrected  ///< and dark pulses have shown since that it is in step
  };
  Kind kind{};
  CameraId camera{};
  int pulses = 0;
};

struct CameraAlignment {
  double proven_s = 0.0;  ///< without the time in which it had no frames
  double unproven_s = 0.0, longest_unproven_s = 0.0;
  std::uint32_t slips_found = 0, slips_corrected = 0;
};

/// Of a whole run.
struct CodeReport {
  std::uint32_t group = 0;
  /// Add to a pulse's number to have the board's, modulo the length of the code; none: not found.
  std::optional<std::uint64_t> phase;
  std::uint64_t dark_pulses = 0;  ///< sets that were known to be dark when they came
  std::vector<CameraAlignment> cameras;
};

/// For each camera a log-likelihood of every slip k from -8 to 8: a camera with slip k shows, as the picture
/// of pulse p, the exposure k pulses earlier. A picture speaks for or against k by being dark or lit where
/// pulse p - k is coded dark or not.
///
/// Proven: no slip is 100,000 times likelier than any other. Between frames of two runs (Frame::run) any slip
/// may have happened, so a camera is unproven from the first frame of a new run, in that very set, until a
/// dark pulse agrees. A slip is found when it is 50 times likelier than anything else, a dark picture fits
/// it, and another camera was dark where it should be at that time (else the code has moved for all). It
/// needs no more certainty, because the camera stays unproven until a dark pulse agrees, and a wrong move
/// shows like any other slip.
///
/// Thread-bound; nothing is allocated after construction.
class CodeAlignment {
 public:
  static constexpr int kMostSlip = 8;

  CodeAlignment(const PulseCode& code, std::size_t cameras);
  CodeAlignment(const CodeAlignment&) = delete;
  CodeAlignment& operator=(const CodeAlignment&) = delete;

  /// The next set: one entry for each camera. Pulses may be missing; one that is not later than the last
  /// begins everything anew.
  void add(std::uint64_t pulse, Timestamp exposed, std::span<const SeenLight> seen) noexcept;

  /// Bit set of cameras that are not proven, as of the last set.
  std::uint32_t unproven() const noexcept;
  /// Coded dark; false while the phase is not known.
  bool dark(std::uint64_t pulse) const noexcept { return phase_ && code_.dark(pulse + *phase_); }
  /// What to ask of FrameSource::shift(). Pictures with another Frame::shifted are on their way since before
  /// it took effect, and are no evidence.
  int wanted_shift(CameraId camera) const noexcept { return cameras_[index(camera)].wanted_shift; }
  /// Of the last add().
  std::span<const AlignmentEvent> events() const noexcept { return {events_.data(), event_count_}; }
  const CodeReport& report() const noexcept { return report_; }

 private:
  static constexpr std::size_t kSlips = 2 * kMostSlip + 1;
  struct Camera {
    LightHistory history;
    std::array<float, kSlips> likelihood{};  // logarithms, the largest is 0
    std::uint32_t dark_fits = 0;             // bit set of slips that a dark picture has fitted
    std::uint32_t run = 0;
    bool known = false;  // whether a frame with wanted_shift was seen
    bool proven = false, correcting = false;
    int wanted_shift = 0;
    // Last pulses in which its picture was dark, where that is coded and elsewhere.
    std::optional<std::uint64_t> agreed_at;
    std::uint64_t strange_at = 0;
    double unproven_for_s = 0.0;
  };
  void look(Camera& camera, CameraId id, std::uint64_t pulse, const SeenLight& seen) noexcept;
  void weigh(Camera& camera, CameraId id, const LightEvidence& evidence) noexcept;
  bool dark_soon(std::uint64_t pulse) const noexcept;
  bool others_agree(const Camera& camera) const noexcept;
  void watch_phase(const LightEvidence& evidence) noexcept;
  void search(const LightEvidence& evidence) noexcept;
  void forget_phase() noexcept;
  static void loosen(Camera& camera) noexcept;
  static void begin(Camera& camera) noexcept;
  void count_time(Timestamp exposed, std::span<const SeenLight> seen) noexcept;
  void say(AlignmentEvent::Kind kind, CameraId camera = {}, int pulses = 0) noexcept;

  PulseCode code_;
  CodeSearch search_;
  std::optional<std::uint64_t> phase_;
  std::vector<Camera> cameras_;
  std::optional<std::uint64_t> last_pulse_;
  Timestamp last_exposed_{};
  // Since a dark pulse was last seen where it is expected: pulses that should have been dark, and were not
  // the other way round.
  std::uint64_t last_contradiction_ = 0;
  unsigned contradictions_ = 0, strange_darks_ = 0;
  bool vain_said_ = false;
  std::array<AlignmentEvent, 40> events_{};
  std::size_t event_count_ = 0;
  CodeReport report_;
};

}  // namespace glint
