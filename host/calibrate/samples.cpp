// SPDX-License-Identifier: MIT
#include "host/calibrate/samples.hpp"

#include <algorithm>
#include <array>
#include <charconv>
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

void take_header(const json& header, SampleSet& samples) {
  if (header.at("kind") != "glint samples") throw Error("is no file of calibration samples");
  if (header.at("format") != 1)
    throw Error("is of format " + header.at("format").dump() + "; this glint reads 1");
  const json& target = header.at("target");
  const auto kind = std::find(kKinds.begin(), kKinds.end(), target.at("kind").get<std::string>());
  if (kind == kKinds.end()) throw Error("target.kind must be marker, wand or board");
  samples.target.kind = static_cast<TargetKind>(kind - kKinds.begin());
  samples.target.name = target.at("name").get<std::string>();
  samples.target.marker_radius_m = target.at("marker_radius_m").get<double>();
  samples.target.points_in_target.clear();
  for (const json& p : target.at("points_in_target_m")) {
    const auto xyz = p.get<std::array<double, 3>>();
    samples.target.points_in_target.emplace_back(xyz[0], xyz[1], xyz[2]);
  }
  if (samples.target.points_in_target.empty()) throw Error("target.points_in_target_m is empty");
  samples.rate_hz = header.at("rate_hz").get<double>();
  for (const json& c : header.at("cameras")) {
    samples.cameras.push_back({c.at("name").get<std::string>(), c.at("width_px").get<std::uint32_t>(),
                               c.at("height_px").get<std::uint32_t>()});
  }
}

Sighting sighting_of(const json& row, const SampleSet& samples) {
  if (!row.is_array() || row.size() != 5) throw Error("expected [tick, camera, point, x_px, y_px]");
  Sighting s;
  s.tick = row[0].get<std::uint64_t>();
  s.camera = row[1].get<std::uint32_t>();
  s.point = row[2].get<std::uint32_t>();
  s.pixel = {row[3].get<double>(), row[4].get<double>()};
  if (s.camera >= samples.cameras.size()) throw Error("there is no camera " + std::to_string(s.camera));
  if (s.point >= samples.target.points_in_target.size())
    throw Error("the target has no point " + std::to_string(s.point));
  return s;
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
      }
    } catch (const std::exception& e) {
      throw Error(path.string() + ":" + std::to_string(line_number) + ": " + e.what());
    }
  }
  if (samples.cameras.empty()) throw Error(path.string() + ": is empty: no calibration samples");
  const std::size_t rows = samples.sightings.size();
  put_in_order(samples);
  if (samples.sightings.size() != rows)
    throw Error(path.string() + ": some point is listed twice for the same tick and camera");
  return samples;
}

void write_samples(const std::filesystem::path& path, const SampleSet& samples, bool force) {
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
