// SPDX-License-Identifier: MIT
// Reading of CSV lines and numbers.
#include "host/capture/csv_reader.hpp"

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>

#include "host/base/error.hpp"

namespace glint {
namespace {

constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";
constexpr std::string_view kBlanks = " \t\r";

}  // namespace

CsvReader::CsvReader(const std::filesystem::path& path) : path_(path.string()) {
  errno = 0;
  file_.open(path);
  if (!file_) throw Error(path_ + ": cannot be read: " + std::strerror(errno));
}

bool CsvReader::next() {
  for (;;) {
    if (!std::getline(file_, line_)) {
      if (file_.bad()) throw Error(path_ + ": reading failed after line " + std::to_string(line_number_));
      return false;
    }
    ++line_number_;
    std::string_view rest = line_;
    if (line_number_ == 1 && rest.starts_with(kByteOrderMark)) rest.remove_prefix(kByteOrderMark.size());
    const std::size_t content = rest.find_first_not_of(kBlanks);
    if (content == std::string_view::npos || rest[content] == '#') continue;
    fields_.clear();
    for (;;) {
      const std::size_t comma = rest.find(',');
      std::string_view text = rest.substr(0, comma);
      text.remove_prefix(std::min(text.find_first_not_of(kBlanks), text.size()));
      text = text.substr(0, text.find_last_not_of(kBlanks) + 1);
      fields_.push_back({text, static_cast<std::size_t>(text.data() - line_.data()) + 1});
      if (comma == std::string_view::npos) return true;
      rest.remove_prefix(comma + 1);
    }
  }
}

template <typename T>
T CsvReader::number(std::size_t field, std::string_view name, const char* expected) const {
  if (field >= fields_.size()) {
    fail(field,
         std::string(name) + " is missing: the line has " + std::to_string(fields_.size()) + " columns");
  }
  const std::string_view text = fields_[field].text;
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) {
    fail(field, std::string(name) + " must be " + expected + ", not \"" + std::string(text) + "\"");
  }
  return value;
}

double CsvReader::real(std::size_t field, std::string_view name) const {
  const auto value = number<double>(field, name, "a number");
  if (!std::isfinite(value)) fail(field, std::string(name) + " must be finite");
  return value;
}

std::uint64_t CsvReader::whole(std::size_t field, std::string_view name, std::uint64_t largest) const {
  const auto value = number<std::uint64_t>(field, name, "a whole number from 0");
  if (value > largest) fail(field, std::string(name) + " must be at most " + std::to_string(largest));
  return value;
}

std::int64_t CsvReader::signed_whole(std::size_t field, std::string_view name) const {
  return number<std::int64_t>(field, name, "a whole number");
}

void CsvReader::fail(std::size_t field, const std::string& what) const {
  const std::size_t column = field < fields_.size() ? fields_[field].column : line_.size() + 1;
  throw Error(path_ + ":" + std::to_string(line_number_) + ":" + std::to_string(column) + ": " + what);
}

}  // namespace glint
