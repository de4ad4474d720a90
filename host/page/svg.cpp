// SPDX-License-Identifier: MIT
// Elements of an SVG picture as text.
#include "host/page/svg.hpp"

#include "host/page/page_text.hpp"

namespace glint::svg {
namespace {

std::string element(std::string_view name, std::string_view kind) {
  std::string s = "<";
  return s.append(name).append(" class=\"").append(kind).append("\"");
}

std::string attribute(std::string_view name, double value) {
  std::string s = " ";
  return s.append(name).append("=\"" + coordinate(value) + "\"");
}

std::string styled(std::string_view style) {
  return style.empty() ? "" : " style=\"" + std::string(style) + "\"";
}

std::string ended(std::string_view name, std::string_view title) {
  if (title.empty()) return "/>";
  return "><title>" + escape_html(title) + "</title></" + std::string(name) + ">";
}

}  // namespace

std::string coordinate(double value) { return short_number(value, 1); }

std::string begin(double width, double height, const std::string& what) {
  return "<svg viewBox=\"0 0 " + coordinate(width) + " " + coordinate(height) +
         "\" role=\"img\" aria-label=\"" + escape_html(what) + "\">";
}

std::string line(std::string_view kind, double x1, double y1, double x2, double y2) {
  return element("line", kind) + attribute("x1", x1) + attribute("y1", y1) + attribute("x2", x2) +
         attribute("y2", y2) + "/>";
}

std::string label(std::string_view kind, double x, double y, std::string_view text) {
  return element("text", kind) + attribute("x", x) + attribute("y", y) + ">" + escape_html(text) + "</text>";
}

std::string rectangle(std::string_view kind, double x, double y, double width, double height,
                      std::string_view style, std::string_view title) {
  return element("rect", kind) + styled(style) + attribute("x", x) + attribute("y", y) +
         attribute("width", width) + attribute("height", height) + ended("rect", title);
}

std::string circle(std::string_view kind, double x, double y, double radius, std::string_view title) {
  return element("circle", kind) + attribute("cx", x) + attribute("cy", y) + attribute("r", radius) +
         ended("circle", title);
}

std::string path(std::string_view kind, std::string_view commands, std::string_view style) {
  return element("path", kind) + styled(style) + " d=\"" + std::string(commands) + "\"/>";
}

}  // namespace glint::svg
