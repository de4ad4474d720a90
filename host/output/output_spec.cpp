// SPDX-License-Identifier: MIT
// Reads the argument of `--output`.
#include "host/output/output_spec.hpp"

#include "host/base/error.hpp"

namespace glint {

namespace {

[[noreturn]] void refuse(std::string_view text, const std::string& why) {
  throw UsageError("--output " + std::string(text.empty() ? "''" : text) + ": " + why +
                   "; use csv:FILE, csv:-, jsonl:FILE, jsonl:- or none (- is standard output)");
}

}  // namespace

OutputSpec parse_output_spec(std::string_view text, bool force) {
  OutputSpec spec;
  spec.force = force;
  if (text == "none") return spec;
  const std::size_t colon = text.find(':');
  const std::string_view kind = text.substr(0, colon);
  if (kind == "csv") {
    spec.kind = OutputKind::Csv;
  } else if (kind == "jsonl") {
    spec.kind = OutputKind::Jsonl;
  } else if (kind == "none") {
    refuse(text, "none takes no file");
  } else {
    refuse(text, std::string(kind) + " is not a kind of output");
  }
  if (colon == std::string_view::npos || colon + 1 == text.size()) {
    refuse(text, "the file is missing after " + std::string(kind) + ":");
  }
  spec.path = std::string(text.substr(colon + 1));
  if (spec.path.find('\0') != std::string::npos) refuse(text, "the file name holds a zero byte");
  return spec;
}

}  // namespace glint
