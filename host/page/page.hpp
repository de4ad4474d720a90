// SPDX-License-Identifier: MIT
// An HTML page that needs nothing but itself: its frame, and a style for light and dark.
#pragma once

#include <string>
#include <string_view>

namespace glint {

/// `style` comes after that of all pages; `body` stands in <main>, `script` at the end. Both may be empty.
/// All are HTML already but for the title.
std::string page_html(const std::string& title, std::string_view style, std::string_view body,
                      std::string_view script);

}  // namespace glint
