// SPDX-License-Identifier: MIT
// Sums over the ledger.
#include "host/assemble/ledger.hpp"

#include <algorithm>
#include <numeric>

namespace glint {

std::uint64_t CameraLedger::total() const noexcept {
  return std::accumulate(count.begin(), count.end(), std::uint64_t{0});
}

bool Ledger::balanced() const noexcept {
  return std::all_of(cameras.begin(), cameras.end(),
                     [this](const CameraLedger& camera) { return camera.total() == pulses; });
}

}  // namespace glint
