// SPDX-License-Identifier: MIT
// What `--output` accepts and how it refuses the rest.
#include "host/output/output_spec.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/base/error.hpp"

namespace glint {
namespace {

using testing::HasSubstr;

TEST(OutputSpec, NamesKindAndFile) {
  const OutputSpec csv = parse_output_spec("csv:tracks.csv");
  EXPECT_EQ(csv.kind, OutputKind::Csv);
  EXPECT_EQ(csv.path, "tracks.csv");
  EXPECT_FALSE(csv.to_stdout());
  EXPECT_FALSE(csv.force);
  const OutputSpec jsonl = parse_output_spec("jsonl:-", true);
  EXPECT_EQ(jsonl.kind, OutputKind::Jsonl);
  EXPECT_TRUE(jsonl.to_stdout());
  EXPECT_TRUE(jsonl.force);
  EXPECT_TRUE(parse_output_spec("csv:-").to_stdout());
  EXPECT_EQ(parse_output_spec("none").kind, OutputKind::None);
}

TEST(OutputSpec, OnlyTheFirstColonParts) { EXPECT_EQ(parse_output_spec("csv:a:b.csv").path, "a:b.csv"); }

TEST(OutputSpec, RefusalQuotesTheTextAndListsTheChoices) {
  for (const char* wrong : {"", "csv", "csv:", "jsonl:", "xml:a", "none:a", ":a", "CSV:a", "tracks.csv"}) {
    try {
      static_cast<void>(parse_output_spec(wrong));
      FAIL() << "accepted '" << wrong << "'";
    } catch (const UsageError& error) {
      EXPECT_THAT(error.what(), HasSubstr(wrong));
      EXPECT_THAT(error.what(), HasSubstr("csv:FILE"));
    }
  }
}

TEST(OutputSpec, RefusalSaysWhatIsWrong) {
  const auto message = [](const char* text) -> std::string {
    try {
      static_cast<void>(parse_output_spec(text));
    } catch (const UsageError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(message("xml:a"), HasSubstr("xml is not a kind of output"));
  EXPECT_THAT(message("csv:"), HasSubstr("the file is missing"));
}

}  // namespace
}  // namespace glint
