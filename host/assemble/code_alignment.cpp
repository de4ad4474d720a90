// SPDX-License-Identifier: MIT
// Bayes' rule over the slips of each camera.
#include "host/assemble/code_alignment.hpp"

#include <algorithm>

#include "host/base/check.hpp"

namespace glint {
namespace {

constexpr float kProven = 11.5F;    // ln(1e5): no slip against any other
constexpr float kSlipped = 3.9F;    // ln(50): a slip against anything else
constexpr float kIrregular = 4.6F;  // ln(100): between two runs, one certain slip happens with this chance
constexpr float kRegular = 17.0F;   // and within a run, between two dark pulses, with e^-17
constexpr unsigned kLostAfter = 6, kStrangeDarks = 3;  // dark pulses
constexpr std::size_t kNoSlip = CodeAlignment::kMostSlip;

}  // namespace

CodeAlignment::CodeAlignment(const PulseCode& code, std::size_t cameras)
    : code_(code), search_(code_, cameras), cameras_(cameras) {
  GLINT_CHECK(cameras > 0 && cameras <= 32);
  report_.group = code_.group();
  report_.cameras.resize(cameras);
  for (Camera& camera : cameras_) begin(camera);
}

void CodeAlignment::say(AlignmentEvent::Kind kind, CameraId camera, int pulses) noexcept {
  if (event_count_ < events_.size()) events_[event_count_++] = {kind, camera, pulses};
}

/// Nothing is known of its slip but that most cameras have none.
void CodeAlignment::begin(Camera& camera) noexcept {
  camera.likelihood.fill(-kIrregular);
  camera.likelihood[kNoSlip] = 0.0F;
  camera.dark_fits = 0;
  camera.proven = false;
  camera.history.clear();
}

/// Any slip may have happened since the last frame.
void CodeAlignment::loosen(Camera& camera) noexcept {
  for (float& likelihood : camera.likelihood) likelihood = std::max(likelihood, -kIrregular);
  camera.proven = false;
}

void CodeAlignment::forget_phase() noexcept {
  phase_.reset();
  report_.phase.reset();
  search_.restart();
  contradictions_ = strange_darks_ = 0;
  for (Camera& camera : cameras_) {
    begin(camera);
    camera.agreed_at.reset();
    camera.strange_at = 0;
  }
}

void CodeAlignment::add(std::uint64_t pulse, Timestamp exposed, std::span<const SeenLight> seen) noexcept {
  GLINT_CHECK(seen.size() == cameras_.size());
  event_count_ = 0;
  if (last_pulse_ && pulse <= *last_pulse_) {
    if (phase_) say(AlignmentEvent::Kind::PhaseLost);
    forget_phase();
  }
  for (std::size_t n = 0; n < seen.size(); ++n) {
    if (seen[n].frame) look(cameras_[n], CameraId{static_cast<std::uint8_t>(n)}, pulse, seen[n]);
  }
  if (dark(pulse)) ++report_.dark_pulses;
  count_time(exposed, seen);
  last_pulse_ = pulse;
}

void CodeAlignment::look(Camera& camera, CameraId id, std::uint64_t pulse, const SeenLight& seen) noexcept {
  if (seen.shifted != camera.wanted_shift) return;
  if (!camera.known) {
    begin(camera);
    camera.known = true;
    camera.run = seen.run;
  }
  // First what is said of the picture before, which belongs to the run before.
  if (const std::optional<LightEvidence> evidence = camera.history.add(pulse, seen.blobs)) {
    if (phase_) {
      weigh(camera, id, *evidence);
      watch_phase(*evidence);
    } else {
      search(*evidence);
    }
  }
  if (seen.run != camera.run) loosen(camera);
  camera.run = seen.run;
}

void CodeAlignment::search(const LightEvidence& evidence) noexcept {
  phase_ = search_.add(evidence);
  if (phase_) {
    report_.phase = phase_;
    say(AlignmentEvent::Kind::PhaseFound);
  } else if (search_.in_vain() && !vain_said_) {
    vain_said_ = true;
    say(AlignmentEvent::Kind::NoPhase);
  }
}

void CodeAlignment::weigh(Camera& camera, CameraId id, const LightEvidence& evidence) noexcept {
  if (!evidence.lit) {
    if (dark(evidence.pulse)) {
      camera.agreed_at = evidence.pulse;
    } else {
      camera.strange_at = evidence.pulse;
    }
  }
  float most = -1e9F;
  std::size_t best = 0;
  const std::uint64_t pulse = evidence.pulse + *phase_ + code_.length();
  for (std::size_t k = 0; k < kSlips; ++k) {
    const bool should_be_dark = code_.dark(pulse + kNoSlip - k);
    float& likelihood = camera.likelihood[k];
    if (should_be_dark == evidence.lit) {
      likelihood += evidence.log_mistaken;
    } else if (!evidence.lit) {
      camera.dark_fits |= 1U << k;
    }
    if (likelihood > most) best = k;
    most = std::max(most, likelihood);
  }
  float next = -1e9F;
  for (std::size_t k = 0; k < kSlips; ++k) {
    float& likelihood = camera.likelihood[k];
    likelihood = std::max(likelihood - most, -kRegular);
    if (k != best) next = std::max(next, likelihood);
  }
  camera.proven = best == kNoSlip && next <= -kProven;
  CameraAlignment& report = report_.cameras[index(id)];
  if (camera.proven) {
    camera.dark_fits = 0;
    if (camera.correcting) {
      ++report.slips_corrected;
      say(AlignmentEvent::Kind::SlipCorrected, id);
    }
    camera.correcting = false;
  } else if (best != kNoSlip && next <= -kSlipped && (camera.dark_fits >> best & 1U) != 0 &&
             !dark_soon(evidence.pulse) && others_agree(camera)) {
    const int slip = static_cast<int>(best) - kMostSlip;
    camera.wanted_shift -= slip;
    camera.known = false;
    camera.correcting = true;
    ++report.slips_found;
    say(AlignmentEvent::Kind::SlipFound, id, slip);
  }
}

/// Then the dark pulse itself is waited for: a picture shortly before it may be dark for another reason.
bool CodeAlignment::dark_soon(std::uint64_t pulse) const noexcept {
  for (int ahead = 1; ahead <= kMostSlip; ++ahead) {
    if (dark(pulse + static_cast<std::uint64_t>(ahead))) return true;
  }
  return false;
}

/// Some other camera was dark where it should be, near or after the pulse in which this one was dark
/// elsewhere.
bool CodeAlignment::others_agree(const Camera& camera) const noexcept {
  return std::any_of(cameras_.begin(), cameras_.end(), [&](const Camera& other) {
    return &other != &camera && other.agreed_at && *other.agreed_at + kMostSlip >= camera.strange_at;
  });
}

/// The board may have been restarted, which moves the code for all cameras by any number of pulses.
void CodeAlignment::watch_phase(const LightEvidence& evidence) noexcept {
  const bool expected = dark(evidence.pulse);
  if (expected && evidence.lit && (contradictions_ == 0 || last_contradiction_ != evidence.pulse)) {
    ++contradictions_;
    last_contradiction_ = evidence.pulse;
  }
  if (!expected && !evidence.lit) ++strange_darks_;
  if (expected && !evidence.lit) contradictions_ = strange_darks_ = 0;
  if (contradictions_ < kLostAfter || strange_darks_ < kStrangeDarks) return;
  say(AlignmentEvent::Kind::PhaseLost);
  forget_phase();
}

std::uint32_t CodeAlignment::unproven() const noexcept {
  std::uint32_t bits = 0;
  for (std::size_t n = 0; n < cameras_.size(); ++n) {
    if (!cameras_[n].proven || !cameras_[n].known) bits |= 1U << n;
  }
  return bits;
}

void CodeAlignment::count_time(Timestamp exposed, std::span<const SeenLight> seen) noexcept {
  const double passed_s = last_pulse_ ? std::max(0.0, seconds_between(last_exposed_, exposed)) : 0.0;
  last_exposed_ = exposed;
  const std::uint32_t bits = unproven();
  for (std::size_t n = 0; n < cameras_.size(); ++n) {
    CameraAlignment& report = report_.cameras[n];
    Camera& camera = cameras_[n];
    if ((bits >> n & 1U) == 0) {
      if (seen[n].frame) report.proven_s += passed_s;
      camera.unproven_for_s = 0.0;
      continue;
    }
    report.unproven_s += passed_s;
    camera.unproven_for_s += passed_s;
    report.longest_unproven_s = std::max(report.longest_unproven_s, camera.unproven_for_s);
  }
}

}  // namespace glint
