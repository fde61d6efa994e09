// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "laser_verdict.hpp"
#include "residual_text.hpp"
#include "text_file.hpp"

namespace raybundle::apps {
namespace {

namespace fs = std::filesystem;
using ::testing::AnyOf;
using ::testing::HasSubstr;

const fs::path kFormats = RAYBUNDLE_SOURCE_DIR "/docs/formats";

// Keys of objects, and of those within.
void expect_named(const nlohmann::ordered_json& json, const std::string& docs) {
  for (const auto& [key, value] : json.items()) {
    if (json.is_object()) {
      EXPECT_THAT(docs, AnyOf(HasSubstr("`" + key + "`"), HasSubstr("`" + key + "[]`")));
    }
    if (value.is_structured()) expect_named(value, docs);
  }
}

TEST(FormatDocs, NameEveryKeyOfAValidation) {
  ResidualBias bias;
  bias.parts.resize(1);
  bias.bands.resize(1);
  LaserVerdict laser;
  laser.wavelength.emplace();
  const std::string docs = text_of(kFormats / "validation.md");
  expect_named(json_from_bias(bias), docs);
  expect_named(json_of(laser), docs);
}

TEST(FormatDocs, ListEveryPage) {
  const std::string list = text_of(kFormats / "README.md");
  for (const auto& entry : fs::directory_iterator(kFormats)) {
    const std::string name = entry.path().filename().string();
    if (name == "README.md") continue;
    EXPECT_THAT(list, HasSubstr("(" + name + ")"));
  }
}

}  // namespace
}  // namespace raybundle::apps
