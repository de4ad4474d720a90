// SPDX-License-Identifier: MIT
// Which id was on which marker, and what became of both: fragments, swaps, returns.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

namespace glint::sim {

/// Thread-bound. Allocates only beyond 4096 ids.
class IdHistory {
 public:
  struct Counts {
    std::uint64_t fragments = 0;     ///< a marker goes on under an id that was on no marker before
    std::uint64_t swaps = 0;         ///< an id goes to another marker than it was on; an exchange is two
    std::uint64_t silent_swaps = 0;  ///< of these: the id was not ambiguous on the way
    std::uint64_t returns = 0;       ///< a marker gets back an id that had been on it and on no other since
  };

  explicit IdHistory(std::size_t markers);

  /// A sample that is that marker beyond doubt. Id 0 is none.
  void on_marker(std::uint32_t id, std::uint32_t marker, bool ambiguous);
  /// Any other sample of that id: near several markers, near none, second best on one, or predicted.
  void elsewhere(std::uint32_t id, bool ambiguous);
  /// The marker that the id was on last.
  std::optional<std::uint32_t> marker_of(std::uint32_t id) const noexcept;

  const Counts& counts() const noexcept { return counts_; }

 private:
  struct Id {
    std::uint32_t id = 0;
    std::optional<std::uint32_t> marker;
    bool ambiguous = false;  // at any time since it was last on its marker, that time included
  };
  Id& at(std::uint32_t id);

  std::vector<Id> ids_;                 // ascending
  std::vector<std::uint32_t> last_id_;  // per marker; 0: none yet
  Counts counts_;
};

}  // namespace glint::sim
