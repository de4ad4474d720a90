// SPDX-License-Identifier: MIT
// Body files: TOML to structs and back.
#include "host/config/bodies_file.hpp"

#include <algorithm>
#include <array>

#include "host/base/error.hpp"
#include "host/config/number_text.hpp"
#include "host/config/read_calibration.hpp"
#include "host/config/rig.hpp"
#include "host/config/toml_section.hpp"
#include "host/config/write_checked.hpp"
#include "host/files/text_file.hpp"

namespace glint {
namespace {

BodyModel read_body(const toml::table& table, std::size_t number, FileProblems& problems) {
  const std::string prefix = "body " + std::to_string(number);
  TomlSection section(table, prefix, problems);
  BodyModel body;
  bool complete = section.text("name", body.name, Need::Required);
  std::vector<std::array<double, 3>> points;
  complete &= section.points("markers_in_body_m", points, Need::Required);
  for (const auto& [x, y, z] : points) body.markers_in_body.emplace_back(x, y, z);
  const bool has_sd = section.has("marker_sd_m");
  complete &= section.number("marker_sd_m", body.marker_sd_m, Need::Optional) || !has_sd;
  section.finish();
  if (!complete) return body;
  // The model speaks of "body.KEY"; here the section has a number, and the key a place.
  std::vector<std::string> complaints;
  body.check(complaints);
  for (const std::string& complaint : complaints) {
    const std::size_t dot = complaint.find('.'), blank = complaint.find(' ');
    section.problem(complaint.substr(dot + 1, blank - dot - 1), complaint.substr(blank + 1));
  }
  return body;
}

/// What the text of a file says of bodies; a rig file is looked at for nothing else.
std::vector<BodyModel> parse_bodies(std::string_view text, FileProblems& problems) {
  const auto table = parse_toml(text, problems);
  if (!table) return {};
  TomlSection top(*table, "", problems);
  const auto kind = read_header(top, problems);
  if (!kind) return {};
  if (*kind == FileKind::Calibration) {
    top.problem("kind", "is \"calibration\"; here a body or rig file is wanted");
    return {};
  }
  const std::vector<BodyModel> bodies = read_body_sections(top, problems);
  if (!top.has("body")) problems.add(top.where(), "no body; add a [[body]] section for each");
  if (*kind == FileKind::Bodies) top.finish();
  return bodies;
}

}  // namespace

std::vector<BodyModel> read_body_sections(TomlSection& top, FileProblems& problems) {
  std::vector<BodyModel> bodies;
  const toml::array* tables = top.tables("body", Need::Optional);
  if (!tables) return bodies;
  for (const toml::node& node : *tables) {
    bodies.push_back(read_body(*node.as_table(), bodies.size() + 1, problems));
    const std::string& name = bodies.back().name;
    const auto first = std::find_if(bodies.begin(), bodies.end() - 1,
                                    [&](const BodyModel& other) { return other.name == name; });
    if (name.empty() || first == bodies.end() - 1) continue;
    problems.add(node.as_table()->get("name")->source().begin,
                 "body " + std::to_string(bodies.size()) + ".name \"" + name + "\" is taken by body " +
                     std::to_string(first - bodies.begin() + 1));
  }
  return bodies;
}

std::vector<BodyModel> read_bodies(const std::filesystem::path& path) {
  FileProblems problems(path);
  std::vector<BodyModel> bodies = parse_bodies(read_text_file(path, kMaxConfigFileBytes), problems);
  throw_problems(problems.lines());
  return bodies;
}

std::string body_section(const BodyModel& body) {
  std::string text = "\n[[body]]\nname = " + quoted_text(body.name) + "\nmarkers_in_body_m = [\n";
  for (const Eigen::Vector3d& p : body.markers_in_body)
    text += "  [" + exact_text(p.x()) + ", " + exact_text(p.y()) + ", " + exact_text(p.z()) + "],\n";
  return text + "]\nmarker_sd_m = " + exact_text(body.marker_sd_m) + "\n";
}

std::string to_toml(std::span<const BodyModel> bodies) {
  std::string text =
      "# Rigid bodies: where the centres of their markers are, in metres, in a frame of the body's own.\n"
      "# marker_sd_m: how well that is known (standard deviation per axis).\n"
      "format = 1\nkind = \"bodies\"\n";
  for (const BodyModel& body : bodies) text += body_section(body);
  return text;
}

void write_bodies(const std::filesystem::path& path, std::span<const BodyModel> bodies, bool force) {
  write_checked(path, to_toml(bodies), parse_bodies,
                "a body file must not replace; write to another file, and copy its [[body]] sections", force);
}

}  // namespace glint
