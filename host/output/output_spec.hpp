// SPDX-License-Identifier: MIT
// What `--output` says: the kind of text and where it goes.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace glint {

enum class OutputKind : std::uint8_t { None, Csv, Jsonl };

struct OutputSpec {
  OutputKind kind = OutputKind::None;
  std::string path;    ///< "-" is standard output; empty for None
  bool force = false;  ///< an existing file may be replaced

  bool to_stdout() const noexcept { return kind != OutputKind::None && path == "-"; }
};

/// "csv:FILE", "csv:-", "jsonl:FILE", "jsonl:-" or "none". Throws UsageError that quotes `text` and
/// lists what is possible. Does not look at the file.
OutputSpec parse_output_spec(std::string_view text, bool force = false);

}  // namespace glint
