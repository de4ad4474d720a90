// SPDX-License-Identifier: MIT
// Elements of an SVG picture as text. What they look like is said by classes of the page's style sheet.
#pragma once

#include <string>
#include <string_view>

namespace glint::svg {

/// Places in user units of the viewBox; y points down.
std::string coordinate(double value);
/// `what` is read aloud to those who do not see the picture. Ends with "</svg>".
std::string begin(double width, double height, const std::string& what);
std::string line(std::string_view kind, double x1, double y1, double x2, double y2);
std::string label(std::string_view kind, double x, double y, std::string_view text);
/// `style`: a style attribute's content; `title` is shown when pointed at. Both may be empty.
std::string rectangle(std::string_view kind, double x, double y, double width, double height,
                      std::string_view style = {}, std::string_view title = {});
std::string circle(std::string_view kind, double x, double y, double radius, std::string_view title = {});
std::string path(std::string_view kind, std::string_view commands, std::string_view style = {});

}  // namespace glint::svg
