// SPDX-License-Identifier: MIT
// Ids mostly come in ascending order, so a sorted list grows at its end.
#include "host/sim/id_history.hpp"

#include <algorithm>

namespace glint::sim {

IdHistory::IdHistory(std::size_t markers) : last_id_(markers) { ids_.reserve(4096); }

IdHistory::Id& IdHistory::at(std::uint32_t id) {
  const auto place = std::lower_bound(
      ids_.begin(), ids_.end(), id, [](const Id& known, std::uint32_t wanted) { return known.id < wanted; });
  if (place != ids_.end() && place->id == id) return *place;
  return *ids_.insert(place, {id, std::nullopt, false});
}

std::optional<std::uint32_t> IdHistory::marker_of(std::uint32_t id) const noexcept {
  const auto place = std::lower_bound(
      ids_.begin(), ids_.end(), id, [](const Id& known, std::uint32_t wanted) { return known.id < wanted; });
  return place != ids_.end() && place->id == id ? place->marker : std::nullopt;
}

void IdHistory::on_marker(std::uint32_t id, std::uint32_t marker, bool ambiguous) {
  if (id == 0) return;
  Id& known = at(id);
  std::uint32_t& last_id = last_id_[marker];
  if (known.marker && *known.marker != marker) {
    ++counts_.swaps;
    if (!known.ambiguous && !ambiguous) ++counts_.silent_swaps;
  } else if (last_id != 0 && last_id != id) {
    ++(known.marker ? counts_.returns : counts_.fragments);
  }
  known.marker = marker;
  known.ambiguous = ambiguous;
  last_id = id;
}

void IdHistory::elsewhere(std::uint32_t id, bool ambiguous) {
  if (id == 0) return;
  Id& known = at(id);
  known.ambiguous = known.ambiguous || ambiguous;
}

}  // namespace glint::sim
