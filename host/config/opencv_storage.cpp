// SPDX-License-Identifier: MIT
// OpenCV's FileStorage, YAML and XML, as far as calibrations need it: numbers, texts and matrices at the top
// level.
#include "host/config/opencv_storage.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <pugixml.hpp>

#include "host/base/error.hpp"
#include "host/config/number_text.hpp"

namespace glint {
namespace {

constexpr std::size_t kMaxMatrixSide = 100'000;

/// Checks that rows, columns and number of values agree.
StorageMatrix make_matrix(const std::string& rows, const std::string& cols, std::vector<double> values,
                          const std::string& where) {
  const auto side = [&](const std::string& text, const char* name) {
    const auto number = parse_number(text);
    if (!number || *number < 0 || *number > kMaxMatrixSide ||
        *number != static_cast<double>(static_cast<long>(*number))) {
      throw Error(where + ": the matrix has no valid number of " + name);
    }
    return static_cast<std::size_t>(*number);
  };
  StorageMatrix matrix{side(rows, "rows"), side(cols, "cols"), std::move(values)};
  if (matrix.rows * matrix.cols != matrix.values.size()) {
    throw Error(where + ": the matrix says " + rows + "x" + cols + " but holds " +
                std::to_string(matrix.values.size()) + " numbers");
  }
  return matrix;
}

double number_in(const std::string& text, const std::string& where) {
  const auto number = parse_number(text);
  if (!number) throw Error(where + ": \"" + text.substr(0, 40) + "\" is not a finite number");
  return *number;
}

std::string yaml_place(const InputFile& file, const YAML::Mark& mark) {
  if (mark.is_null()) return file.path.string() + ":1:1";
  return file.path.string() + ":" + std::to_string(mark.line + 1) + ":" + std::to_string(mark.column + 1);
}

std::vector<double> yaml_numbers(const YAML::Node& list, const InputFile& file) {
  std::vector<double> values;
  for (const auto& element : list) {
    const std::string where = yaml_place(file, element.Mark());
    if (!element.IsScalar()) throw Error(where + ": a number is wanted here");
    values.push_back(number_in(element.Scalar(), where));
  }
  return values;
}

bool all_numbers(const YAML::Node& list) {
  return std::all_of(list.begin(), list.end(), [](const YAML::Node& element) {
    return element.IsScalar() && parse_number(element.Scalar()).has_value();
  });
}

OpenCvStorage read_yaml(const InputFile& file) {
  // OpenCV writes "%YAML:1.0", which is no YAML directive: blank it, so that lines keep their numbers.
  std::string text = file.text;
  if (text.compare(0, 5, "%YAML") == 0) {
    std::fill_n(text.begin(), std::min(text.find_first_of("\r\n"), text.size()), ' ');
  }
  OpenCvStorage storage;
  const YAML::Node root = YAML::Load(text);
  if (!root.IsMap()) throw Error(yaml_place(file, root.Mark()) + ": not a list of \"key: value\"");
  for (const auto& pair : root) {
    if (!pair.first.IsScalar()) continue;
    const YAML::Node& value = pair.second;
    StorageEntry entry;
    entry.where = yaml_place(file, value.Mark());
    if (value.IsScalar()) {
      entry.text = value.Scalar();
    } else if (value.IsMap() && value["rows"] && value["cols"] && value["data"]) {
      if (!value["rows"].IsScalar() || !value["cols"].IsScalar() || !value["data"].IsSequence()) {
        throw Error(entry.where + ": a matrix has rows, cols and a list of data");
      }
      entry.matrix = make_matrix(value["rows"].Scalar(), value["cols"].Scalar(),
                                 yaml_numbers(value["data"], file), entry.where);
    } else if (value.IsSequence() && all_numbers(value)) {
      const std::vector<double> values = yaml_numbers(value, file);
      entry.matrix = StorageMatrix{1, values.size(), values};
    } else {
      continue;
    }
    storage[pair.first.Scalar()] = std::move(entry);
  }
  return storage;
}

std::vector<std::string> words_in(const std::string& text) {
  std::vector<std::string> words;
  constexpr const char* kBlanks = " \t\r\n";
  for (auto first = text.find_first_not_of(kBlanks); first != std::string::npos;) {
    const auto end = std::min(text.find_first_of(kBlanks, first), text.size());
    words.push_back(text.substr(first, end - first));
    first = text.find_first_not_of(kBlanks, end);
  }
  return words;
}

std::vector<double> xml_numbers(const std::string& text, const std::string& where) {
  std::vector<double> values;
  for (const std::string& word : words_in(text)) values.push_back(number_in(word, where));
  return values;
}

std::string xml_place(const InputFile& file, const pugi::xml_node& node) {
  const auto offset = node.offset_debug();
  return place_of(file, offset > 0 ? static_cast<std::size_t>(offset) : 0);
}

OpenCvStorage read_xml(const InputFile& file) {
  pugi::xml_document document;
  const auto result = document.load_buffer(file.text.data(), file.text.size());
  if (!result) {
    throw Error(place_of(file, static_cast<std::size_t>(std::max<std::ptrdiff_t>(result.offset, 0))) +
                ": not XML: " + result.description());
  }
  const pugi::xml_node root = document.child("opencv_storage");
  if (!root) throw Error(file.path.string() + ":1:1: the element <opencv_storage> is missing");
  OpenCvStorage storage;
  for (const pugi::xml_node& node : root.children()) {
    if (node.type() != pugi::node_element) continue;
    StorageEntry entry;
    entry.where = xml_place(file, node);
    if (node.child("rows") && node.child("cols") && node.child("data")) {
      entry.matrix = make_matrix(node.child_value("rows"), node.child_value("cols"),
                                 xml_numbers(node.child_value("data"), xml_place(file, node.child("data"))),
                                 entry.where);
    } else if (!node.first_child().first_child()) {
      const std::vector<std::string> words = words_in(node.child_value());
      entry.text = node.child_value();
      if (words.size() == 1) entry.text = words[0];
      const bool numbers = std::all_of(
          words.begin(), words.end(), [](const std::string& word) { return parse_number(word).has_value(); });
      if (words.size() > 1 && numbers) {
        const std::vector<double> values = xml_numbers(node.child_value(), entry.where);
        entry.matrix = StorageMatrix{1, values.size(), values};
      }
    }
    storage[node.name()] = std::move(entry);
  }
  return storage;
}

}  // namespace

OpenCvStorage read_opencv_storage(const InputFile& file) {
  const auto first = file.text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  if (first != std::string::npos && file.text[first] == '<') return read_xml(file);
  try {
    return read_yaml(file);
  } catch (const YAML::Exception& error) {
    throw Error(yaml_place(file, error.mark) + ": not YAML: " + error.msg);
  }
}

}  // namespace glint
