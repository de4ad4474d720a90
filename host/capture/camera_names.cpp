// SPDX-License-Identifier: MIT
// Natural order and matching of camera names.
#include "host/capture/camera_names.hpp"

#include <algorithm>
#include <set>

#include "gpu/detector.hpp"
#include "host/base/error.hpp"

namespace glint {
namespace {

bool is_digit(char c) noexcept { return c >= '0' && c <= '9'; }

/// The run of digits at `at`, without leading zeros; moves `at` behind it.
std::string_view take_digits(std::string_view text, std::size_t& at) noexcept {
  while (at < text.size() && text[at] == '0') ++at;
  const std::size_t begin = at;
  while (at < text.size() && is_digit(text[at])) ++at;
  return text.substr(begin, at - begin);
}

}  // namespace

bool natural_less(std::string_view a, std::string_view b) noexcept {
  std::size_t i = 0, j = 0;
  while (i < a.size() && j < b.size()) {
    if (is_digit(a[i]) && is_digit(b[j])) {
      const std::string_view m = take_digits(a, i), n = take_digits(b, j);
      if (m.size() != n.size()) return m.size() < n.size();
      if (m != n) return m < n;
    } else {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i, ++j;
    }
  }
  if (a.size() - i != b.size() - j) return a.size() - i < b.size() - j;
  return a < b;  // they differ in leading zeros only, or not at all
}

std::string join_names(const std::vector<std::string>& names) {
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
  return all;
}

std::vector<std::size_t> select_cameras(const std::vector<std::string>& found,
                                        const std::vector<std::string>& wanted, const std::string& where) {
  if (found.empty()) throw Error(where + ": holds no cameras");
  for (const auto* names : {&found, &wanted}) {
    std::set<std::string> once;
    for (const std::string& name : *names) {
      if (!once.insert(name).second) {
        throw Error((names == &found ? where : "the rig") + ": camera \"" + name + "\" occurs twice");
      }
    }
  }
  std::vector<std::size_t> selected;
  std::vector<std::string> lacking;
  for (const std::string& name : wanted.empty() ? found : wanted) {
    const auto at = std::find(found.begin(), found.end(), name);
    if (at == found.end()) {
      lacking.push_back(name);
    } else {
      selected.push_back(static_cast<std::size_t>(at - found.begin()));
    }
  }
  if (!lacking.empty()) {
    throw Error(where + ": camera names do not match: the rig wants " + join_names(wanted) +
                "; the source has " + join_names(found) + "; not found: " + join_names(lacking) +
                ". Rename one side, or leave the cameras out of the rig");
  }
  if (selected.size() > gpu::kMaxCameras) {
    throw Error(where + ": " + std::to_string(selected.size()) + " cameras, possible are " +
                std::to_string(gpu::kMaxCameras));
  }
  return selected;
}

}  // namespace glint
