// SPDX-License-Identifier: MIT
// One line, one fault.
#include "tests/device/uvc_camera/fault_script.hpp"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <optional>
#include <sstream>

#include "host/base/error.hpp"

namespace glint::device {
namespace {

struct Word {
  std::string_view text;
  FaultKind kind;
  bool has_amount;
};

constexpr Word kWords[] = {
    {"never", FaultKind::Never, false},
    {"twice", FaultKind::Twice, false},
    {"stale", FaultKind::Stale, false},
    {"error-bit", FaultKind::ErrorBit, false},
    {"toggle", FaultKind::Toggle, false},
    {"broken-packet", FaultKind::BrokenPacket, false},
    {"truncated", FaultKind::Truncated, false},
    {"corrupt", FaultKind::Corrupt, false},
    {"late", FaultKind::Late, true},
    {"hang", FaultKind::Hang, false},
    {"resume", FaultKind::Resume, false},
    {"unplug", FaultKind::Unplug, false},
    {"replug", FaultKind::Replug, false},
    {"dark", FaultKind::Dark, false},
    {"slip", FaultKind::Slip, true},
};

template <typename Number>
std::optional<Number> number_of(std::string_view text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

std::optional<Fault> fault_of(std::string_view text) {
  const std::size_t colon = text.find(':');
  for (const Word& word : kWords) {
    if (word.text != text.substr(0, colon)) continue;
    if (word.has_amount != (colon != std::string_view::npos)) return std::nullopt;
    if (!word.has_amount) return Fault{word.kind, 0.0};
    const std::optional<double> amount = number_of<double>(text.substr(colon + 1));
    if (!amount || *amount < 0.0 || *amount > 1e6) return std::nullopt;
    return Fault{word.kind, *amount};
  }
  return std::nullopt;
}

}  // namespace

std::string_view word_of(FaultKind kind) noexcept {
  return std::find_if(std::begin(kWords), std::end(kWords), [&](const Word& w) { return w.kind == kind; })
      ->text;
}

FaultScript::FaultScript(std::istream& text, const std::string& name, unsigned cameras) {
  std::string line;
  for (unsigned number = 1; std::getline(text, line); ++number) {
    std::istringstream words(line.substr(0, line.find('#')));
    std::string pulse_word, camera_word, fault_word, rest;
    if (!(words >> pulse_word)) continue;
    words >> camera_word >> fault_word;
    const auto fail = [&](const std::string& what) {
      throw Error(name + ":" + std::to_string(number) + ": " + what + " (lines are PULSE CAMERA FAULT)");
    };
    const std::optional<std::uint64_t> pulse = number_of<std::uint64_t>(pulse_word);
    if (!pulse) fail("'" + pulse_word + "' is no pulse");
    const std::optional<unsigned> camera = number_of<unsigned>(camera_word);
    if (camera_word != "*" && (!camera || *camera < 1 || *camera > cameras))
      fail("'" + camera_word + "' is no camera from 1 to " + std::to_string(cameras) + " and not *");
    const std::optional<Fault> fault = fault_of(fault_word);
    if (!fault || words >> rest) fail("'" + fault_word + (rest.empty() ? "" : " " + rest) + "' is no fault");
    const unsigned first = camera ? *camera - 1 : 0, last = camera ? *camera - 1 : cameras - 1;
    for (unsigned c = first; c <= last; ++c) faults_[{*pulse, c}].push_back(*fault);
  }
}

FaultScript FaultScript::read(const std::filesystem::path& path, unsigned cameras) {
  std::ifstream file(path);
  if (!file) throw Error(path.string() + ": cannot be read");
  return FaultScript(file, path.string(), cameras);
}

const std::vector<Fault>& FaultScript::at(std::uint64_t pulse, unsigned camera) const noexcept {
  static const std::vector<Fault> none;
  const auto found = faults_.find({pulse, camera});
  return found == faults_.end() ? none : found->second;
}

}  // namespace glint::device
