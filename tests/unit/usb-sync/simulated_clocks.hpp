// SPDX-License-Identifier: MIT
// A board's clock that drifts, and a USB stack and scheduler that delay what is said about it.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

#include "usb-sync/clock_model.hpp"

namespace glint::sync {

/// Time goes on by calls of run_to(); seconds of board time since the start.
class SimulatedClocks {
 public:
  static constexpr std::uint32_t kTickHz = 125'000'000;
  static constexpr double kWireRequest_s = 11.5e-6, kWireAnswer_s = 42e-6;

  struct Delays {
    double request_s = 1e-3;    ///< up to so long until the bus takes a request: the polling grid
    double answer_s = 0.2e-3;   ///< up to so long from the wire to the program
    double report_s = 1e-3;     ///< as above, for reports that come by themselves
    double stall_s = 4e-3;      ///< the scheduler looks elsewhere for up to so long
    double stall_share = 0.02;  ///< in so many of all steps
  };

  SimulatedClocks(std::uint64_t seed, const Delays& delays) : random_(seed), delays_(delays) {
    rate_error_ = 50e-6 * signed_share();
    swing_ = 0.1e-6 * std::abs(signed_share());  // per second
    turn_ = 2.0 * std::numbers::pi / (20.0 + 80.0 * share());
    phase_ = 2.0 * std::numbers::pi * share();
    first_tick_ = random_() % (1ull << 50);
    first_host_ = HostTime(std::chrono::nanoseconds(random_() % (1ull << 50)));
  }

  std::uint64_t tick(double board_s) const {
    return first_tick_ + static_cast<std::uint64_t>(std::llround(board_s * kTickHz));
  }
  /// The truth. The rate's change swings with the temperature: swing * cos(turn * t + phase).
  HostTime host(double board_s) const {
    const double wander = -swing_ / (turn_ * turn_) * std::cos(turn_ * board_s + phase_);
    return first_host_ +
           std::chrono::nanoseconds(std::llround(1e9 * (board_s * (1.0 + rate_error_) + wander)));
  }

  /// A query whose request reaches the board at that time.
  TimeAnswer query(double board_s) {
    TimeAnswer answer;
    answer.tick = tick(board_s);
    answer.asked = host(board_s - kWireRequest_s - delays_.request_s * share() - stall());
    answer.answered = host(board_s + kWireAnswer_s + delays_.answer_s * share() + stall());
    return answer;
  }
  HostTime arrival(double board_s) {
    return host(board_s + kWireAnswer_s + delays_.report_s * share() + stall());
  }

  double share() { return std::uniform_real_distribution<double>()(random_); }

 private:
  double signed_share() { return 2.0 * share() - 1.0; }
  double stall() { return share() < delays_.stall_share ? delays_.stall_s * share() : 0.0; }

  std::mt19937_64 random_;
  Delays delays_;
  double rate_error_, swing_, turn_, phase_;
  std::uint64_t first_tick_;
  HostTime first_host_;
};

}  // namespace glint::sync
