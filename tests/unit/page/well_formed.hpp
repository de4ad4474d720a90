// SPDX-License-Identifier: MIT
// Whether the tags of a page fit together.
#pragma once

#include <set>
#include <string>
#include <vector>

namespace glint::test {

/// Every tag is closed by its own end tag, in order. Enough for what the page uses.
inline std::string unbalanced(const std::string& html) {
  const std::set<std::string> empty{"!doctype", "meta"};
  std::vector<std::string> open;
  for (std::size_t at = 0; (at = html.find('<', at)) != std::string::npos;) {
    const std::size_t end = html.find('>', at);
    if (end == std::string::npos) return "a tag without end";
    const bool closing = html[at + 1] == '/';
    const std::size_t from = at + (closing ? 2 : 1);
    const std::string name = html.substr(from, html.find_first_of(" />", from) - from);
    at = end + 1;
    if (closing) {
      if (open.empty() || open.back() != name) return "</" + name + "> out of place";
      open.pop_back();
    } else if (html[end - 1] != '/' && empty.count(name) == 0) {
      open.push_back(name);
      if (name == "script" || name == "style") at = html.find("</" + name, at);
    }
  }
  return open.empty() ? "" : "<" + open.back() + "> is not closed";
}

}  // namespace glint::test
