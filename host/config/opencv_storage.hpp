// SPDX-License-Identifier: MIT
// OpenCV's FileStorage, YAML and XML, as far as calibrations need it: numbers, texts and matrices at the top
// level.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "host/config/raw_calibration.hpp"

namespace glint {

struct StorageMatrix {
  std::size_t rows = 0, cols = 0;
  std::vector<double> values;  ///< row by row
};

struct StorageEntry {
  std::string where;                    ///< "file:line:column" of the value
  std::string text;                     ///< a scalar as written; empty for other kinds
  std::optional<StorageMatrix> matrix;  ///< of a matrix, or of a plain list of numbers (one row)
};

using OpenCvStorage = std::map<std::string, StorageEntry>;

/// Reads the top level of a file; keys of other kinds (nested maps, lists of words) are left out. Throws
/// glint::Error with file:line:column for broken syntax and broken matrices.
OpenCvStorage read_opencv_storage(const InputFile& file);

}  // namespace glint
