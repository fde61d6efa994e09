// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/uncertainty/requirements.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

using ::testing::HasSubstr;

TEST(Requirements, ReadsTheWordsOfPeople) {
  const Requirement depth = requirement_from_text("depth 20 mm at 1 m");
  EXPECT_EQ(depth.quantity, Quantity::kDepth);
  EXPECT_DOUBLE_EQ(depth.limit, 0.02);
  EXPECT_DOUBLE_EQ(depth.range_m, 1.0);

  const Requirement projection = requirement_from_text("projection 0.2px at 50cm over 110° for left");
  EXPECT_EQ(projection.quantity, Quantity::kProjection);
  EXPECT_DOUBLE_EQ(projection.limit, 0.2);
  EXPECT_DOUBLE_EQ(projection.range_m, 0.5);
  EXPECT_DOUBLE_EQ(*projection.field_rad, 110 * M_PI / 180);
  EXPECT_EQ(projection.camera, "left");

  EXPECT_EQ(requirement_from_text("projection 1e-1 px at infinity").range_m, kInfinitelyFar);
  EXPECT_EQ(requirement_from_text("projection 0.1 px").range_m, kInfinitelyFar);
  EXPECT_DOUBLE_EQ(requirement_from_text("coverage 80 %").limit, 0.8);
  EXPECT_DOUBLE_EQ(requirement_from_text("baseline 50um").limit, 50e-6);
}

// Each message names the word and what would be understood.
TEST(Requirements, SaysWhatIsNotUnderstood) {
  const std::pair<const char*, const char*> cases[] = {
      {"", "empty"},
      {"deepth 20 mm at 1 m", "Did you mean \"depth\""},
      {"depth 20 px at 1 m", "mm, cm, m"},
      {"depth 20 mm", "at which"},
      {"depth -20 mm at 1 m", "above zero"},
      {"depth mm at 1 m", "above zero"},
      {"depth nan mm at 1 m", "above zero"},
      {"depth 20 mm at infinity", "infinitely far"},
      {"rms 0.3", "px"},
      {"rms 0.3 px at 1 m", "cannot follow"},
      {"rms 0.3 px for", "cannot follow"},
      {"rms 0.3 px for left for right", "'for' stands twice"},
      {"projection 0.2 px over 110 px", "deg"},
  };
  for (const auto& [text, part] : cases) {
    try {
      requirement_from_text(text);
      ADD_FAILURE() << "'" << text << "' was understood";
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kBadInput);
      EXPECT_THAT(error.what(), HasSubstr(part)) << text;
    }
  }
}

}  // namespace
}  // namespace raybundle
