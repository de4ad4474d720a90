// SPDX-License-Identifier: MIT
// Layout of the page, and its two file formats.
#include "host/target/board_page.hpp"

#include <array>
#include <charconv>
#include <cstdarg>
#include <cstdio>
#include <utility>
#include <vector>

#include "host/base/error.hpp"

namespace glint {
namespace {

constexpr double kMargin_mm = 8.0;   // printers leave 5 mm white; finders need a light edge
constexpr double kFooter_mm = 14.0;  // ruler and text, below the board
constexpr double kRuler_mm = 100.0;
constexpr double kText_mm = 3.2;  // height of the letters

struct Rectangle {
  double x_mm = 0.0, y_mm = 0.0, width_mm = 0.0, height_mm = 0.0;
};
struct Text {
  double x_mm = 0.0, y_mm = 0.0;  // left end of its base line
  std::string words;
};
/// Everything on the page is black; y points down from the upper edge.
struct Drawing {
  PageSize page;
  std::vector<Rectangle> black;
  std::vector<Text> texts;
};

std::string filled(const char* format, ...) __attribute__((format(printf, 1, 2)));
std::string filled(const char* format, ...) {
  char text[240];
  std::va_list values;
  va_start(values, format);
  std::vsnprintf(text, sizeof text, format, values);
  va_end(values);
  return text;
}

Drawing draw(const BoardSpec& board, PageSize page) {
  const double width_mm = 1e3 * board.square_m * board.squares_across,
               height_mm = 1e3 * board.square_m * board.squares_down;
  const double needed_width = std::max(width_mm, kRuler_mm) + 2.0 * kMargin_mm,
               needed_height = height_mm + 2.0 * kMargin_mm + kFooter_mm;
  const auto fits = [&] { return needed_width <= page.width_mm && needed_height <= page.height_mm; };
  if (!fits()) std::swap(page.width_mm, page.height_mm);
  if (!fits()) {
    throw Error(
        filled("board %s: measures %g x %g mm and needs a page of %g x %g mm with its margins and ruler, not "
               "%g x %g mm; take a larger page (--page a3) or smaller squares",
               to_text(board).c_str(), width_mm, height_mm, needed_width, needed_height,
               std::max(page.width_mm, page.height_mm), std::min(page.width_mm, page.height_mm)));
  }
  const BoardPattern pattern = board_pattern(board);
  Drawing drawing;
  drawing.page = page;
  const double left = 0.5 * (page.width_mm - width_mm), top = 0.5 * (page.height_mm - kFooter_mm - height_mm);
  for (const Eigen::AlignedBox2d& area : pattern.black) {
    const Eigen::Vector2d from = 1e3 * (area.min() - pattern.squares.min()), size = 1e3 * area.sizes();
    drawing.black.push_back({left + from.x(), top + from.y(), size.x(), size.y()});
  }
  const double ruler_x = 0.5 * (page.width_mm - kRuler_mm), ruler_y = page.height_mm - kMargin_mm - 5.0;
  drawing.black.push_back({ruler_x, ruler_y, kRuler_mm, 0.2});
  for (int tick = 0; tick <= 10; ++tick) {  // the outer edges of the first and the last are 100 mm apart
    const double length = tick % 5 == 0 ? 3.0 : 1.5;
    drawing.black.push_back({ruler_x + tick * (kRuler_mm - 0.2) / 10.0, ruler_y - length, 0.2, length});
  }
  drawing.texts.push_back(
      {ruler_x, ruler_y + 4.0, to_text(board) + "   print at 100 %; this line must measure 100 mm"});
  return drawing;
}

std::string svg_number(double value) { return filled("%.4f", value); }

}  // namespace

PageSize parse_page(std::string_view text) {
  constexpr std::array<std::pair<std::string_view, PageSize>, 7> kKnown{{{"a4", {297.0, 210.0}},
                                                                         {"a3", {420.0, 297.0}},
                                                                         {"a2", {594.0, 420.0}},
                                                                         {"a1", {841.0, 594.0}},
                                                                         {"a0", {1189.0, 841.0}},
                                                                         {"letter", {279.4, 215.9}},
                                                                         {"tabloid", {431.8, 279.4}}}};
  std::string lower(text);
  for (char& c : lower)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c + 32);
  for (const auto& [name, size] : kKnown)
    if (lower == name) return size;
  const auto number = [](std::string_view word, double& value) {
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
    return error == std::errc{} && end == word.data() + word.size() && value >= 20.0 && value <= 5000.0;
  };
  const auto cross = lower.find('x');
  PageSize page;
  if (cross != std::string::npos && lower.ends_with("mm") &&
      number(std::string_view(lower).substr(0, cross), page.width_mm) &&
      number(std::string_view(lower).substr(cross + 1, lower.size() - cross - 3), page.height_mm)) {
    return page;
  }
  throw UsageError("page \"" + std::string(text) +
                   "\": must be a4, a3, a2, a1, a0, letter, tabloid or WIDTHxHEIGHTmm, like 500x400mm");
}

std::string board_svg(const BoardSpec& board, const PageSize& size) {
  const Drawing drawing = draw(board, size);
  const std::string width = svg_number(drawing.page.width_mm), height = svg_number(drawing.page.height_mm);
  std::string svg = "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + width + "mm\" height=\"" + height +
                    "mm\" viewBox=\"0 0 " + width + " " + height + "\">\n<title>" + to_text(board) +
                    "</title>\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
                    "<path fill=\"black\" shape-rendering=\"crispEdges\" d=\"\n";
  for (const Rectangle& r : drawing.black) {
    svg += "M" + svg_number(r.x_mm) + " " + svg_number(r.y_mm) + "h" + svg_number(r.width_mm) + "v" +
           svg_number(r.height_mm) + "h-" + svg_number(r.width_mm) + "z\n";
  }
  svg += "\"/>\n";
  for (const Text& text : drawing.texts) {
    svg += "<text x=\"" + svg_number(text.x_mm) + "\" y=\"" + svg_number(text.y_mm) + "\" font-size=\"" +
           svg_number(kText_mm) + "\" font-family=\"Helvetica, Arial, sans-serif\">" + text.words +
           "</text>\n";
  }
  return svg + "</svg>\n";
}

std::string board_pdf(const BoardSpec& board, const PageSize& size) {
  const Drawing drawing = draw(board, size);
  constexpr double kPoints = 72.0 / 25.4;  // a millimetre
  std::string page = "0 g\n";
  for (const Rectangle& r : drawing.black) {  // PDF counts from the lower edge
    page += filled("%.5f %.5f %.5f %.5f re\n", r.x_mm * kPoints,
                   (drawing.page.height_mm - r.y_mm - r.height_mm) * kPoints, r.width_mm * kPoints,
                   r.height_mm * kPoints);
  }
  page += "f\n";
  for (const Text& text : drawing.texts) {  // nothing in these words needs escaping
    page += filled("BT /F1 %.3f Tf %.4f %.4f Td (%s) Tj ET\n", kText_mm * kPoints, text.x_mm * kPoints,
                   (drawing.page.height_mm - text.y_mm) * kPoints, text.words.c_str());
  }
  const std::array<std::string, 5> objects{
      "<< /Type /Catalog /Pages 2 0 R /ViewerPreferences << /PrintScaling /None >> >>",
      "<< /Type /Pages /Kids [3 0 R] /Count 1 >>",
      filled("<< /Type /Page /Parent 2 0 R /MediaBox [0 0 %.4f %.4f] /Contents 4 0 R /Resources << /Font << "
             "/F1 5 0 R "
             ">> >> >>",
             drawing.page.width_mm * kPoints, drawing.page.height_mm * kPoints),
      "<< /Length " + std::to_string(page.size()) + " >>\nstream\n" + page + "endstream",
      "<< /Type /Font /Subtype /Type1 /BaseFont /Helvetica >>"};
  std::string pdf = "%PDF-1.6\n";
  std::string table = "xref\n0 6\n0000000000 65535 f \n";
  for (std::size_t n = 0; n < objects.size(); ++n) {
    table += filled("%010zu 00000 n \n", pdf.size());
    pdf += std::to_string(n + 1) + " 0 obj\n" + objects[n] + "\nendobj\n";
  }
  const std::size_t start = pdf.size();
  return pdf + table + "trailer\n<< /Size 6 /Root 1 0 R >>\nstartxref\n" + std::to_string(start) +
         "\n%%EOF\n";
}

}  // namespace glint
