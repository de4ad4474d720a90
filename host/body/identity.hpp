// SPDX-License-Identifier: MIT
// Which of several bodies of one shape is which: doubts, how they arise and how they end.
#pragma once

#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "host/body/body_state.hpp"
#include "host/body/swap_hypothesis.hpp"

namespace glint {

/// Keeps all doubts. Two bodies can be in doubt about each other once; a symmetric body about itself.
class Identity {
 public:
  Identity(const BodyShapes& shapes, const BodyTrackerOptions& options);

  void advance(double seconds) noexcept;

  /// After the fits of an exposure and before the motions take them in. Looks at every pair of one shape that
  /// was measured: exchanges their measurements where the tracks have gone over from one to the other, starts
  /// a doubt where the odds are too close, weighs the doubts that there are, and ends those that are decided.
  /// Bodies whose samples changed are fitted anew by `refit(body)`.
  template <typename Refit>
  void compare(std::span<BodyState> bodies, std::vector<BodyEvent>& events, BodyCounters& counters,
               Refit&& refit) {
    for (const auto& [a, b] : pairs_) {
      if (!bodies[a].fitted || !bodies[b].fitted || !near(bodies[a], bodies[b])) continue;
      const double odds = odds_of(bodies[a], bodies[b]);
      if (odds < 0.0) {
        exchange_measurements(bodies[a], bodies[b]);
        refit(a);
        refit(b);
      }
      if (std::abs(odds) < options_.ambiguity_log_odds && doubt_between(a, b) == nullptr)
        doubt_crossing(a, b, bodies, events, counters);
    }
    weigh(bodies, events, counters);
  }

  /// Two bodies were given out by `log_odds`, which is too close; `motions` lead to where they are now, and
  /// on the other way round. Without them (nullptr) nothing can decide it but a person.
  void doubt_found(std::uint32_t a, std::uint32_t b, double log_odds, const BodyMotion* a_as_b,
                   const BodyMotion* b_as_a, std::vector<BodyEvent>& events, BodyCounters& counters);
  /// The body looks the same when turned, by the `markers` that are seen; more of them may decide it.
  void doubt_turn(std::uint32_t body, unsigned markers, std::vector<BodyEvent>& events,
                  BodyCounters& counters);
  void settle(std::uint32_t body) noexcept;
  /// A symmetric body that is lost has no orientation to doubt; other doubts outlive it.
  void lost(std::uint32_t body) noexcept;

  struct Doubt {
    std::uint32_t a = 0, b = 0;
    BodyDoubt why = BodyDoubt::None;
    bool weighed = false;  ///< the motions may still decide it
    unsigned age = 0;      ///< frames in which both were measured
    unsigned markers = 0;  ///< Symmetric: by how many it is not decided
    SwapHypothesis swap;
  };
  /// Any doubt that the body is in; nullptr: none.
  const Doubt* doubt_of(std::uint32_t body) const noexcept;

 private:
  static bool near(const BodyState& a, const BodyState& b) noexcept;
  static double odds_of(const BodyState& a, const BodyState& b) noexcept;
  static void exchange_measurements(BodyState& a, BodyState& b) noexcept;
  const Doubt* doubt_between(std::uint32_t a, std::uint32_t b) const noexcept;
  void doubt_crossing(std::uint32_t a, std::uint32_t b, std::span<const BodyState> bodies,
                      std::vector<BodyEvent>& events, BodyCounters& counters);
  void tell(const Doubt& doubt, BodyEventKind kind, std::vector<BodyEvent>& events) const;
  void weigh(std::span<BodyState> bodies, std::vector<BodyEvent>& events, BodyCounters& counters);

  BodyTrackerOptions options_;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs_;  // of one shape
  std::vector<Doubt> doubts_;
};

}  // namespace glint
