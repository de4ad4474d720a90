// SPDX-License-Identifier: MIT
// Splitting at colons.
#include "host/apps/colon_list.hpp"

#include <algorithm>
#include <utility>

#include "host/base/error.hpp"

namespace glint::apps {

ColonList::ColonList(std::string option, std::string text, std::string form, std::string example)
    : option_(std::move(option)),
      text_(std::move(text)),
      form_(std::move(form)),
      example_(std::move(example)) {
  std::size_t begin = 0;
  for (std::size_t colon = 0; colon != std::string::npos; begin = colon + 1) {
    colon = text_.find(':', begin);
    parts_.push_back(text_.substr(begin, colon - begin));
  }
  const auto wanted = static_cast<std::size_t>(std::count(form_.begin(), form_.end(), ':')) + 1;
  if (parts_.size() != wanted) refuse();
}

std::uint32_t ColonList::camera(std::size_t part) const {
  const auto number = this->number<std::uint32_t>(part);
  if (number == 0) refuse();
  return number - 1;
}

void ColonList::refuse() const {
  throw UsageError(option_ + " " + text_ + ": must be " + form_ + ", like " + example_);
}

}  // namespace glint::apps
