// SPDX-License-Identifier: MIT
// Typed reading of TOML tables that collects every problem with its place instead of stopping at the first.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <toml++/toml.h>

namespace glint {

/// What is wrong with one file.
class FileProblems {
 public:
  explicit FileProblems(const std::filesystem::path& path) : file_(path.string()) {}

  void add(const toml::source_position& at, std::string text);
  bool empty() const noexcept { return entries_.empty(); }
  /// "file:line:column: text", in the order of the file.
  std::vector<std::string> lines() const;

 private:
  struct Entry {
    toml::source_position at;
    std::string text;
  };
  std::string file_;
  std::vector<Entry> entries_;
};

enum class Need : std::uint8_t { Required, Optional };

/// One table of a file. Each key that is read counts as known; finish() reports the others. A read that fails
/// or finds no key leaves the value as it was and returns false.
class TomlSection {
 public:
  /// `name` is the prefix of messages ("detect", "camera 2"); empty for the top of the file. Both references
  /// must outlive the section.
  TomlSection(const toml::table& table, std::string name, FileProblems& problems);

  bool number(std::string_view key, double& value, Need need);
  /// Within [min, max].
  bool whole(std::string_view key, std::uint32_t& value, std::uint32_t min, std::uint32_t max, Need need);
  bool text(std::string_view key, std::string& value, Need need);
  bool flag(std::string_view key, bool& value, Need need);
  /// An array of exactly values.size() finite numbers.
  bool numbers(std::string_view key, std::span<double> values, Need need);
  /// An array of any number of arrays of three finite numbers.
  bool points(std::string_view key, std::vector<std::array<double, 3>>& values, Need need);
  const toml::table* table(std::string_view key, Need need);
  /// An array of tables; nullptr if missing or something else.
  const toml::array* tables(std::string_view key, Need need);

  bool has(std::string_view key) const { return table_.contains(key); }
  /// Of the key's value, or of the section where there is no such key.
  toml::source_position where(std::string_view key) const;
  toml::source_position where() const;
  /// Reports `key` of this section: "name.key text".
  void problem(std::string_view key, const std::string& text);
  /// Reports the keys that nobody read.
  void finish();

 private:
  const toml::node* find(std::string_view key, Need need);
  std::string full_name(std::string_view key) const;

  const toml::table& table_;
  std::string name_;
  FileProblems& problems_;
  std::vector<std::string> known_;
};

/// Throws glint::Error with all lines, if there are any.
void throw_problems(std::span<const std::string> lines);

/// The file's text as TOML; nothing, and a problem, if it is not.
std::optional<toml::table> parse_toml(std::string_view text, FileProblems& problems);

/// `text` as a TOML string, with its quotes.
std::string quoted_text(std::string_view text);

/// The candidate nearest to `word` if it is near enough to be meant, else empty.
std::string nearest_word(std::string_view word, std::span<const std::string> candidates);

}  // namespace glint
