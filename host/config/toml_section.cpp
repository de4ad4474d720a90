// SPDX-License-Identifier: MIT
// Typed reading of TOML tables that collects every problem with its place instead of stopping at the first.
#include "host/config/toml_section.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>
#include <utility>

#include "host/base/error.hpp"
#include "host/config/number_text.hpp"

namespace glint {
namespace {

std::string kind_of(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table:
      return "a table";
    case toml::node_type::array:
      return "an array";
    case toml::node_type::string:
      return "a string";
    case toml::node_type::integer:
      return "a whole number";
    case toml::node_type::floating_point:
      return "a number with a fraction";
    case toml::node_type::boolean:
      return "true or false";
    case toml::node_type::date:
    case toml::node_type::time:
    case toml::node_type::date_time:
      return "a date or time";
    case toml::node_type::none:
      break;
  }
  return "nothing";
}

/// The number in a node, whole or not; nothing for other kinds.
std::optional<double> number_in(const toml::node& node) {
  if (const auto* whole = node.as_integer()) return static_cast<double>(whole->get());
  if (const auto* fraction = node.as_floating_point()) return fraction->get();
  return std::nullopt;
}

std::string not_finite(double value) {
  const char* what = std::isnan(value) ? "nan" : value > 0 ? "inf" : "-inf";
  return std::string("must be a finite number, not ") + what;
}

/// Insertions, deletions, replacements and exchanges of neighbours between two words (optimal string
/// alignment).
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before, last(b.size() + 1), row(b.size() + 1);
  std::iota(last.begin(), last.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      row[j] = std::min({last[j] + 1, row[j - 1] + 1, last[j - 1] + (a[i - 1] == b[j - 1] ? 0u : 1u)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) {
        row[j] = std::min(row[j], before[j - 2] + 1);
      }
    }
    before = last;
    last = row;
  }
  return last[b.size()];
}

}  // namespace

void FileProblems::add(const toml::source_position& at, std::string text) {
  entries_.push_back({at ? at : toml::source_position{1, 1}, std::move(text)});
}

std::vector<std::string> FileProblems::lines() const {
  std::vector<Entry> sorted = entries_;
  std::stable_sort(sorted.begin(), sorted.end(), [](const Entry& a, const Entry& b) {
    return std::pair(a.at.line, a.at.column) < std::pair(b.at.line, b.at.column);
  });
  std::vector<std::string> result;
  for (const Entry& entry : sorted) {
    result.push_back(file_ + ":" + std::to_string(entry.at.line) + ":" + std::to_string(entry.at.column) +
                     ": " + entry.text);
  }
  return result;
}

TomlSection::TomlSection(const toml::table& table, std::string name, FileProblems& problems)
    : table_(table), name_(std::move(name)), problems_(problems) {}

std::string TomlSection::full_name(std::string_view key) const {
  return name_.empty() ? std::string(key) : name_ + "." + std::string(key);
}

toml::source_position TomlSection::where() const { return table_.source().begin; }

toml::source_position TomlSection::where(std::string_view key) const {
  const toml::node* node = table_.get(key);
  return node ? node->source().begin : where();
}

void TomlSection::problem(std::string_view key, const std::string& text) {
  problems_.add(where(key), full_name(key) + " " + text);
}

const toml::node* TomlSection::find(std::string_view key, Need need) {
  known_.emplace_back(key);
  const toml::node* node = table_.get(key);
  if (!node && need == Need::Required) problem(key, "is missing");
  return node;
}

bool TomlSection::number(std::string_view key, double& value, Need need) {
  const toml::node* node = find(key, need);
  if (!node) return false;
  const auto read = number_in(*node);
  if (!read) {
    problem(key, "must be a number, not " + kind_of(*node));
    return false;
  }
  if (!std::isfinite(*read)) {
    problem(key, not_finite(*read));
    return false;
  }
  value = *read;
  return true;
}

bool TomlSection::whole(std::string_view key, std::uint32_t& value, std::uint32_t min, std::uint32_t max,
                        Need need) {
  const toml::node* node = find(key, need);
  if (!node) return false;
  const auto* read = node->as_integer();
  if (!read) {
    problem(key, "must be a whole number, not " + kind_of(*node));
    return false;
  }
  if (read->get() < std::int64_t{min} || read->get() > std::int64_t{max}) {
    const bool negative = min == 0 && read->get() < 0;
    problem(key, (negative ? "must not be negative; it is "
                           : "must be " + std::to_string(min) + " to " + std::to_string(max) + ", not ") +
                     std::to_string(read->get()));
    return false;
  }
  value = static_cast<std::uint32_t>(read->get());
  return true;
}

bool TomlSection::text(std::string_view key, std::string& value, Need need) {
  const toml::node* node = find(key, need);
  if (!node) return false;
  const auto* read = node->as_string();
  if (!read) {
    problem(key, "must be a string, not " + kind_of(*node));
    return false;
  }
  value = read->get();
  return true;
}

bool TomlSection::flag(std::string_view key, bool& value, Need need) {
  const toml::node* node = find(key, need);
  if (!node) return false;
  const auto* read = node->as_boolean();
  if (!read) {
    problem(key, "must be true or false, not " + kind_of(*node));
    return false;
  }
  value = read->get();
  return true;
}

bool TomlSection::numbers(std::string_view key, std::span<double> values, Need need) {
  const toml::node* node = find(key, need);
  if (!node) return false;
  const toml::array* array = node->as_array();
  const std::string wanted = "must be an array of " + std::to_string(values.size()) + " numbers";
  if (!array) {
    problem(key, wanted + ", not " + kind_of(*node));
    return false;
  }
  if (array->size() != values.size()) {
    problem(key, wanted + "; it has " + std::to_string(array->size()));
    return false;
  }
  std::vector<double> read;
  for (const toml::node& element : *array) {
    const auto number = number_in(element);
    if (!number || !std::isfinite(*number)) {
      problems_.add(element.source().begin,
                    full_name(key) + " " +
                        (number ? not_finite(*number) : "must hold numbers only, not " + kind_of(element)));
      continue;
    }
    read.push_back(*number);
  }
  if (read.size() != values.size()) return false;
  std::copy(read.begin(), read.end(), values.begin());
  return true;
}

bool TomlSection::points(std::string_view key, std::vector<std::array<double, 3>>& values, Need need) {
  const toml::node* node = find(key, need);
  if (!node) return false;
  const toml::array* array = node->as_array();
  if (!array) {
    problem(key, "must be an array of points, [[x, y, z], ...], not " + kind_of(*node));
    return false;
  }
  std::vector<std::array<double, 3>> read;
  for (const toml::node& element : *array) {
    const toml::array* point = element.as_array();
    std::string wrong;
    if (!point)
      wrong = "must hold points, [x, y, z], not " + kind_of(element);
    else if (point->size() != 3)
      wrong = "must hold points of three numbers; one has " + std::to_string(point->size());
    std::array<double, 3> numbers{};
    for (std::size_t k = 0; wrong.empty() && k < 3; ++k) {
      const auto number = number_in((*point)[k]);
      if (!number)
        wrong = "must hold numbers only, not " + kind_of((*point)[k]);
      else if (!std::isfinite(*number))
        wrong = not_finite(*number);
      else
        numbers[k] = *number;
    }
    if (wrong.empty())
      read.push_back(numbers);
    else
      problems_.add(element.source().begin, full_name(key) + " " + wrong);
  }
  if (read.size() != array->size()) return false;
  values = std::move(read);
  return true;
}

const toml::table* TomlSection::table(std::string_view key, Need need) {
  const toml::node* node = find(key, need);
  if (!node) return nullptr;
  if (!node->is_table()) problem(key, "must be a table, not " + kind_of(*node));
  return node->as_table();
}

const toml::array* TomlSection::tables(std::string_view key, Need need) {
  const toml::node* node = find(key, need);
  if (!node) return nullptr;
  const toml::array* array = node->as_array();
  if (array && std::all_of(array->begin(), array->end(), [](const toml::node& n) { return n.is_table(); })) {
    return array;
  }
  const std::string brackets = "[[" + std::string(key) + "]]";
  problem(key, node->is_table() ? "must be written " + brackets + " with two pairs of brackets"
                                : "must be a list of " + brackets + " sections, not " + kind_of(*node));
  return nullptr;
}

void TomlSection::finish() {
  for (const auto& [key, value] : table_) {
    if (std::find(known_.begin(), known_.end(), key.str()) != known_.end()) continue;
    std::string text = "unknown key \"" + full_name(key.str()) + "\"";
    const std::string meant = nearest_word(key.str(), known_);
    if (!meant.empty()) text += "; did you mean \"" + meant + "\"?";
    problems_.add(key.source().begin, text);
  }
}

void throw_problems(std::span<const std::string> lines) {
  if (lines.empty()) return;
  std::string text = lines.front();
  for (const std::string& line : lines.subspan(1)) text += "\n" + line;
  throw Error(text);
}

std::optional<toml::table> parse_toml(std::string_view text, FileProblems& problems) {
  try {
    return toml::parse(text);
  } catch (const toml::parse_error& error) {
    problems.add(error.source().begin, "not TOML: " + std::string(error.description()));
    return std::nullopt;
  }
}

std::string quoted_text(std::string_view text) {
  const toml::value<std::string> value{std::string(text)};
  std::ostringstream out;
  out << toml::toml_formatter{value, toml::format_flags::none};
  return out.str();
}

std::string nearest_word(std::string_view word, std::span<const std::string> candidates) {
  const std::size_t near_enough = std::max<std::size_t>(2, word.size() / 3);
  std::string best;
  std::size_t best_distance = near_enough + 1;
  for (const std::string& candidate : candidates) {
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < best_distance && distance < candidate.size()) {
      best = candidate;
      best_distance = distance;
    }
  }
  return best;
}

}  // namespace glint
