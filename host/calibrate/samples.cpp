// SPDX-License-Identifier: MIT
#include "host/calibrate/samples.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <tuple>

#include <nlohmann/json.hpp>

#include "host/base/error.hpp"
#include "host/files/text_file.hpp"

namespace glint {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxFileBytes = std::size_t{1} << 30;
constexpr std::uint64_t kBlock = 10;  // ticks: what a wand or board moves meanwhile makes a new sample
constexpr std::array<const char*, 3> kKinds{"marker", "wand", "board"};

auto order_of(const Sighting& s) { return std::tuple(s.tick, s.camera, s.point); }

/// As it stands in the file: JSON's own conversions cut fractions off and let signs and high bits go.
template <typename Number>
Number whole(const json& value, const std::string& what) {
  if (!value.is_number_unsigned() || value.get<std::uint64_t>() > std::numeric_limits<Number>::max())
    throw Error(what + " is " + value.dump() + ": must be a whole number, not below 0, of " +
                std::to_string(8 * sizeof(Number)) + " bits at most");
  return value.get<Number>();
}

double real(const json& value, const std::string& what) {
  if (!value.is_number()) throw Error(what + " is " + value.dump() + ": must be a number");
  return value.get<double>();
}

double not_negative(const json& value, const std::string& what) {
  const double number = real(value, what);
  if (number < 0.0) throw Error(what + " is " + value.dump() + ": must not be negative");
  return number;
}

/// JSON has no word for anything else.
void check_finite(const std::filesystem::path& path, const SampleSet& samples) {
  const auto fail = [&](const std::string& what) {
    throw Error(path.string() + ": cannot be written: " + what + " is not a finite number");
  };
  for (const Eigen::Vector3d& p : samples.target.points_in_target)
    if (!p.allFinite()) fail("a point of the target");
  if (!std::isfinite(samples.target.marker_radius_m)) fail("the markers' radius");
  if (!std::isfinite(samples.rate_hz)) fail("the rate");
  for (const Sighting& s : samples.sightings)
    if (!s.pixel.allFinite())
      fail("a pixel at tick " + std::to_string(s.tick) + " of camera " + std::to_string(s.camera));
}

json header_of(const SampleSet& samples) {
  json points = json::array();
  for (const Eigen::Vector3d& p : samples.target.points_in_target) points.push_back({p.x(), p.y(), p.z()});
  json cameras = json::array();
  for (const SampleCamera& c : samples.cameras)
    cameras.push_back({{"name", c.name}, {"width_px", c.width_px}, {"height_px", c.height_px}});
  return {{"format", 1},
          {"kind", "glint samples"},
          {"target",
           {{"kind", kKinds[static_cast<std::size_t>(samples.target.kind)]},
            {"name", samples.target.name},
            {"marker_radius_m", samples.target.marker_radius_m},
            {"points_in_target_m", points}}},
          {"rate_hz", samples.rate_hz},
          {"cameras", cameras},
          {"columns", {"tick", "camera", "point", "x_px", "y_px"}}};
}

void check_target(const Target& target) {
  const std::vector<Eigen::Vector3d>& points = target.points_in_target;
  if (points.empty()) throw Error("target.points_in_target_m is empty");
  if (target.kind == TargetKind::Marker && points.size() != 1)
    throw Error("target.points_in_target_m: a marker is one point");
  if (target.kind != TargetKind::Wand) return;
  std::vector<double> places_m;
  for (const Eigen::Vector3d& p : points) {
    if (p.y() != 0.0 || p.z() != 0.0) throw Error("target.points_in_target_m: a wand lies on the x axis");
    places_m.push_back(p.x());
  }
  wand_target(places_m, target.marker_radius_m);
}

void take_header(const json& header, SampleSet& samples) {
  if (!header.is_object()) throw Error("expected the header of a file of calibration samples");
  if (header.at("kind") != "glint samples") throw Error("is no file of calibration samples");
  if (header.at("format") != 1)
    throw Error("is of format " + header.at("format").dump() + "; this glint reads 1");
  const json& target = header.at("target");
  const auto kind = std::find(kKinds.begin(), kKinds.end(), target.at("kind").get<std::string>());
  if (kind == kKinds.end()) throw Error("target.kind must be marker, wand or board");
  samples.target.kind = static_cast<TargetKind>(kind - kKinds.begin());
  samples.target.name = target.at("name").get<std::string>();
  samples.target.marker_radius_m = not_negative(target.at("marker_radius_m"), "target.marker_radius_m");
  samples.target.points_in_target.clear();
  for (const json& p : target.at("points_in_target_m")) {
    const std::string what = "target.points_in_target_m";
    if (!p.is_array() || p.size() != 3) throw Error(what + " has " + p.dump() + ": must be [x, y, z]");
    samples.target.points_in_target.emplace_back(real(p[0], what), real(p[1], what), real(p[2], what));
  }
  check_target(samples.target);
  samples.rate_hz = not_negative(header.at("rate_hz"), "rate_hz");
  for (const json& c : header.at("cameras")) {
    const std::string name = c.at("name").get<std::string>();
    for (const SampleCamera& other : samples.cameras)
      if (other.name == name) throw Error("there are two cameras named " + name);
    samples.cameras.push_back({name, whole<std::uint32_t>(c.at("width_px"), name + "'s width_px"),
                               whole<std::uint32_t>(c.at("height_px"), name + "'s height_px")});
  }
}

Sighting sighting_of(const json& row, const SampleSet& samples) {
  if (!row.is_array() || row.size() != 5) throw Error("expected [tick, camera, point, x_px, y_px]");
  Sighting s;
  s.tick = whole<std::uint64_t>(row[0], "tick");
  s.camera = whole<std::uint32_t>(row[1], "camera");
  s.point = whole<std::uint32_t>(row[2], "point");
  s.pixel = {real(row[3], "x_px"), real(row[4], "y_px")};
  if (s.camera >= samples.cameras.size()) throw Error("there is no camera " + std::to_string(s.camera));
  if (s.point >= samples.target.points_in_target.size())
    throw Error("the target has no point " + std::to_string(s.point));
  return s;
}

/// Index of a sighting of what an earlier one is of, if there is any.
std::optional<std::size_t> second_of_a_pair(const std::vector<Sighting>& sightings) {
  std::vector<std::size_t> order(sightings.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return order_of(sightings[a]) < order_of(sightings[b]);
  });
  for (std::size_t i = 1; i < order.size(); ++i)
    if (order_of(sightings[order[i]]) == order_of(sightings[order[i - 1]])) return order[i];
  return std::nullopt;
}

void append(std::string& text, auto value) {
  char digits[32];
  text.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
}

}  // namespace

std::vector<SampleTick> ticks_of(const SampleSet& samples) {
  std::vector<SampleTick> ticks;
  const std::span<const Sighting> all(samples.sightings);
  for (std::size_t begin = 0, end = 0; begin < all.size(); begin = end) {
    while (end < all.size() && all[end].tick == all[begin].tick) ++end;
    ticks.push_back({all[begin].tick, all.subspan(begin, end - begin)});
  }
  return ticks;
}

void put_in_order(SampleSet& samples) {
  std::vector<Sighting>& all = samples.sightings;
  std::stable_sort(all.begin(), all.end(),
                   [](const Sighting& a, const Sighting& b) { return order_of(a) < order_of(b); });
  std::vector<Sighting> kept;
  for (std::size_t begin = 0, end = 0; begin < all.size(); begin = end) {
    while (end < all.size() && order_of(all[end]) == order_of(all[begin])) ++end;
    if (end - begin == 1) kept.push_back(all[begin]);
  }
  all = std::move(kept);
}

bool held_out(std::uint64_t tick_index) { return tick_index / kBlock % 5 == 4; }

SampleSet read_samples(const std::filesystem::path& path) {
  const std::string text = read_text_file(path, kMaxFileBytes);
  SampleSet samples;
  std::vector<std::uint64_t> lines;  // of the sightings
  std::uint64_t line_number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const char *const first = text.data() + begin, *const last = text.data() + end;
    begin = end + 1;
    ++line_number;
    if (first == last) continue;
    try {
      const json line = json::parse(first, last);
      if (samples.cameras.empty()) {
        take_header(line, samples);
        if (samples.cameras.empty()) throw Error("lists no cameras");
      } else {
        samples.sightings.push_back(sighting_of(line, samples));
        lines.push_back(line_number);
      }
    } catch (const std::exception& e) {
      throw Error(path.string() + ":" + std::to_string(line_number) + ": " + e.what());
    }
  }
  if (samples.cameras.empty()) throw Error(path.string() + ": is empty: no calibration samples");
  if (const auto row = second_of_a_pair(samples.sightings)) {
    throw Error(path.string() + ":" + std::to_string(lines[*row]) + ": point " +
                std::to_string(samples.sightings[*row].point) + " of tick " +
                std::to_string(samples.sightings[*row].tick) + " is listed before for the same camera");
  }
  put_in_order(samples);
  return samples;
}

void write_samples(const std::filesystem::path& path, const SampleSet& samples, bool force) {
  check_finite(path, samples);
  std::string text = header_of(samples).dump() + "\n";
  for (const Sighting& s : samples.sightings) {
    text += '[';
    append(text, s.tick);
    text += ',';
    append(text, s.camera);
    text += ',';
    append(text, s.point);
    text += ',';
    append(text, s.pixel.x());
    text += ',';
    append(text, s.pixel.y());
    text += "]\n";
  }
  write_text_file(path, text, force);
}

}  // namespace glint
