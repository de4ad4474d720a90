// SPDX-License-Identifier: MIT
// Comma-separated values, line by line, with errors that name file, line and column.
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

namespace glint {

/// Streams a file. Empty lines and lines that begin with # are passed over; blanks around fields, carriage
/// returns and a byte order mark are dropped. No quotes: no field of ours needs them. All errors are thrown
/// as Error.
class CsvReader {
 public:
  explicit CsvReader(const std::filesystem::path& path);

  /// Goes to the next line; false at the end of the file.
  bool next();
  std::size_t fields() const noexcept { return fields_.size(); }
  std::string_view text(std::size_t field) const noexcept { return fields_[field].text; }

  // What the field holds, or an error that says what was expected; `name` is the column's.
  double real(std::size_t field, std::string_view name) const;
  std::uint64_t whole(std::size_t field, std::string_view name, std::uint64_t largest) const;
  std::int64_t signed_whole(std::size_t field, std::string_view name) const;

  /// Throws Error("path:line:column: what") for that field of the current line.
  [[noreturn]] void fail(std::size_t field, const std::string& what) const;

 private:
  struct Field {
    std::string_view text;
    std::size_t column = 1;
  };
  template <typename T>
  T number(std::size_t field, std::string_view name, const char* expected) const;
  std::string path_;
  std::ifstream file_;
  std::string line_;
  std::uint64_t line_number_ = 0;
  std::vector<Field> fields_;
};

}  // namespace glint
