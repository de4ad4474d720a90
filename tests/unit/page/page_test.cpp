// SPDX-License-Identifier: MIT
// Texts, elements and the frame of a page.
#include "host/page/page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/page/page_text.hpp"
#include "host/page/svg.hpp"
#include "tests/unit/page/well_formed.hpp"

namespace glint {
namespace {

using test::unbalanced;
using testing::HasSubstr;
using testing::Not;

TEST(PageText, StepsAreRound) {
  EXPECT_DOUBLE_EQ(round_step(10, 5), 2);
  EXPECT_DOUBLE_EQ(round_step(1, 6), 0.2);
  EXPECT_DOUBLE_EQ(round_step(4.9, 6), 1);
  EXPECT_DOUBLE_EQ(round_step(0, 6), 1);
  for (double extent = 1e-4; extent < 1e6; extent *= 1.37) {
    const double parts = extent / round_step(extent, 5);
    EXPECT_GT(parts, 3.4) << extent;
    EXPECT_LT(parts, 8.8) << extent;
  }
}

TEST(PageText, NumbersAreShort) {
  EXPECT_EQ(short_number(0.5), "0.5");
  EXPECT_EQ(short_number(100), "100");
  EXPECT_EQ(short_number(-0.0000001), "0");
  EXPECT_EQ(short_number(1.26, 1), "1.3");
}

TEST(Svg, ElementsAreClosedAndEscaped) {
  const std::string picture = svg::begin(100, 50, "a < b") + svg::line("grid", 0, 0, 1.25, 2) +
                              svg::label("mid", 1, 2, "<&>") + svg::rectangle("bar", 1, 2, 3, 4) +
                              svg::rectangle("bar", 1, 2, 3, 4, "fill:red", "x & y") +
                              svg::circle("dot", 1, 2, 3, "here") + svg::path("curve", "M0 0L1 1") + "</svg>";
  EXPECT_EQ(unbalanced(picture), "");
  EXPECT_THAT(picture, HasSubstr("aria-label=\"a &lt; b\""));
  EXPECT_THAT(picture, HasSubstr("&lt;&amp;&gt;</text>"));
  EXPECT_THAT(picture, HasSubstr("<rect class=\"bar\" style=\"fill:red\" x=\"1\" y=\"2\" width=\"3\" "
                                 "height=\"4\"><title>x &amp; y"));
  EXPECT_THAT(picture, HasSubstr("<line class=\"grid\" x1=\"0\" y1=\"0\" x2=\"1.2\" y2=\"2\"/>"));
}

TEST(Page, IsWellFormedInBothSchemes) {
  const std::string page = page_html("A <title>", ".mine{color:red}", "<p>body</p>", "let x=1<2;");
  EXPECT_EQ(unbalanced(page), "");
  EXPECT_THAT(page, HasSubstr("<title>A &lt;title&gt;</title>"));
  EXPECT_THAT(page, HasSubstr("prefers-color-scheme:dark"));
  EXPECT_THAT(page_html("t", "", "", ""), Not(HasSubstr("<script>")));
}

}  // namespace
}  // namespace glint
