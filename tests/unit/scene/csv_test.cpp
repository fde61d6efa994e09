// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/scene/csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::vector<std::string> fields_of(const std::string& line) { return csv_from_text(line, "t.csv").rows.at(0).fields; }

std::string message_of(const std::string& text) {
  try {
    const CsvTable table = csv_from_text(text, "t.csv");
    number_in(table, table.rows.at(0), 0, "u");
  } catch (const Error& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Csv, SplitsAtCommasOutsideOfQuotes) {
  EXPECT_THAT(fields_of("a, b ,,c"), ElementsAre("a", "b", "", "c"));
  EXPECT_THAT(fields_of("\"a,b\" ,\t\"say \"\"c\"\"\"  , d"), ElementsAre("a,b", "say \"c\"", "d"));
  EXPECT_THAT(fields_of("\"\",\"a\","), ElementsAre("", "a", ""));
}

TEST(Csv, LosesNothingBehindAClosingQuote) {
  for (const char* text : {"\"10\"0.5,1", "\"10\" 5", "\"10\"\"\"x", "1,\"a\"b"}) {
    EXPECT_THAT(message_of(text), HasSubstr("t.csv:1: ")) << text;
    EXPECT_THAT(message_of(text), HasSubstr("behind a closing double quote")) << text;
  }
  EXPECT_THAT(message_of("\"10"), HasSubstr("opened but not closed"));
  EXPECT_EQ(message_of("\"10\" ,5"), "accepted");
}

TEST(Csv, ANumberHasOneSign) {
  for (const char* text : {"5", "+5", "-5", "+.5e1"}) EXPECT_EQ(message_of(text), "accepted");
  for (const char* text : {"+-5", "++5", "--5", "5 5", "inf", "nan", "\"\""}) {
    EXPECT_THAT(message_of(text), HasSubstr("which is not a finite number")) << text;
  }
}

}  // namespace
}  // namespace raybundle
