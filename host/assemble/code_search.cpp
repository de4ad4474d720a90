// SPDX-License-Identifier: MIT
// One score for each phase; a pulse touches only those in which it is dark.
#include "host/assemble/code_search.hpp"

#include <algorithm>
#include <cmath>

namespace glint {
namespace {

constexpr float kMargin = 13.8F;       // ln(1e6)
constexpr std::size_t kLeastFits = 7;  // fewer fit some phase by chance, however clear each is
constexpr std::uint64_t kVainGroups = 32;
constexpr std::uint64_t kNear = 8;

}  // namespace

CodeSearch::CodeSearch(const PulseCode& code, std::size_t cameras)
    : code_(code),
      // What happens to all markers at once happens to all cameras: two must agree to count as one alone.
      share_(cameras > 1 ? 0.5F : 1.0F),
      score_(static_cast<std::size_t>(code.length()), 0.0F) {}

void CodeSearch::restart() noexcept {
  std::fill(score_.begin(), score_.end(), 0.0F);
  dark_count_ = 0;
  any_ = in_vain_ = false;
}

std::optional<std::uint64_t> CodeSearch::add(const LightEvidence& evidence) noexcept {
  if (any_ && evidence.pulse - first_ > kVainGroups * code_.group()) {
    restart();
    in_vain_ = true;
  }
  if (!any_) first_ = evidence.pulse;
  any_ = true;
  const std::uint64_t length = code_.length(), here = evidence.pulse % length;
  const float change = (evidence.lit ? share_ : -share_) * evidence.log_mistaken;
  for (std::uint32_t n = 0; n < PulseCode::kGroups; ++n) {
    const std::uint64_t phase = code_.dark_pulse(n) + length - here;
    score_[static_cast<std::size_t>(phase < length ? phase : phase - length)] += change;
  }
  if (evidence.lit) return std::nullopt;
  const auto known = darks_.begin() + static_cast<std::ptrdiff_t>(dark_count_);
  if (dark_count_ < darks_.size() && std::find(darks_.begin(), known, evidence.pulse) == known)
    darks_[dark_count_++] = evidence.pulse;
  if (dark_count_ < kLeastFits) return std::nullopt;
  const std::optional<std::uint64_t> phase = certain();
  return phase && fits(*phase) ? phase : std::nullopt;
}

bool CodeSearch::fits(std::uint64_t phase) const noexcept {
  const auto known = darks_.begin() + static_cast<std::ptrdiff_t>(dark_count_);
  const auto fitting = static_cast<std::uint64_t>(
      std::count_if(darks_.begin(), known, [&](std::uint64_t pulse) { return code_.dark(pulse + phase); }));
  const std::uint64_t newest = *std::max_element(darks_.begin(), known);
  const std::uint64_t expected = 1 + (newest - std::min(first_, newest)) / code_.group();
  return fitting >= kLeastFits && 5 * fitting >= 4 * expected;
}

std::optional<std::uint64_t> CodeSearch::certain() const noexcept {
  const auto best = std::max_element(score_.begin(), score_.end());
  const auto phase = static_cast<std::uint64_t>(best - score_.begin()), length = code_.length();
  // The others taken together are at most as likely as the best of them times their number.
  const float limit = *best - kMargin - std::log(static_cast<float>(length));
  for (std::uint64_t other = 0; other < length; ++other) {
    const std::uint64_t apart = other > phase ? other - phase : phase - other;
    if (std::min(apart, length - apart) > kNear && score_[static_cast<std::size_t>(other)] > limit)
      return std::nullopt;
  }
  return phase;
}

}  // namespace glint
