// SPDX-License-Identifier: MIT
// CSV of tracks to ticks.
#include "host/apps/recorded_tracks.hpp"

#include <cstdint>
#include <limits>
#include <optional>
#include <string_view>

#include "host/base/error.hpp"
#include "host/capture/csv_reader.hpp"

namespace glint::apps {
namespace {

std::optional<std::size_t> column(const CsvReader& csv, std::string_view name) {
  for (std::size_t k = 0; k < csv.fields(); ++k)
    if (csv.text(k) == name) return k;
  return std::nullopt;
}

std::size_t needed(const CsvReader& csv, std::string_view name) {
  const auto found = column(csv, name);
  if (!found)
    csv.fail(0, "no column \"" + std::string(name) + "\"; record with glint track --output csv:FILE");
  return *found;
}

}  // namespace

std::vector<RecordedTick> read_recorded_tracks(const std::filesystem::path& path) {
  CsvReader csv(path);
  if (!csv.next()) throw Error(path.string() + ": is empty");
  const std::size_t tick_column = needed(csv, "tick"), id = needed(csv, "id"), x = needed(csv, "x_m"),
                    y = needed(csv, "y_m"), z = needed(csv, "z_m");
  const auto kind = column(csv, "kind");
  std::vector<RecordedTick> ticks;
  std::optional<std::uint64_t> last;
  while (csv.next()) {
    const std::uint64_t tick = csv.whole(tick_column, "tick", std::numeric_limits<std::uint64_t>::max());
    if (last && tick < *last) csv.fail(tick_column, "ticks must not go back");
    if (!last || tick != *last) ticks.emplace_back();
    last = tick;
    if (kind && *kind < csv.fields() && csv.text(*kind) != "measured") continue;
    const std::uint64_t track = csv.whole(id, "id", std::numeric_limits<std::uint32_t>::max());
    ticks.back().push_back({TrackId{static_cast<std::uint32_t>(track)},
                            {csv.real(x, "x_m"), csv.real(y, "y_m"), csv.real(z, "z_m")}});
  }
  return ticks;
}

}  // namespace glint::apps
