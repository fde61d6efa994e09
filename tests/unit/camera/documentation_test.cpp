// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cctype>
#include <fstream>
#include <iterator>
#include <string>

#include "raybundle/camera/camera.hpp"

namespace raybundle {
namespace {

using ::testing::HasSubstr;

// With one space for any white space, so that it does not matter where lines end.
std::string documentation() {
  std::ifstream file(RAYBUNDLE_SOURCE_DIR "/docs/formats/camera_models.md");
  std::string text;
  for (std::istreambuf_iterator<char> at(file), end; at != end; ++at) {
    const bool space = std::isspace(static_cast<unsigned char>(*at)) != 0;
    if (!space) text += *at;
    if (space && !text.ends_with(' ')) text += ' ';
  }
  return text;
}

// Who has only the file finds each model with its parameters in their order, and what others call it. Does not check the
// formulas: these are held against other programs' in the oracle tests, and each file has a self-test.
TEST(ModelDocs, NameEveryModelWithItsParametersInOrder) {
  const std::string docs = documentation();
  for (const std::string_view name : model_names()) {
    const ModelId model = *model_named(name);
    std::string heading = "## " + std::string(name) + " Parameters: `";
    for (const std::string_view parameter : parameter_names(model)) heading += std::string(parameter) + " ";
    heading.back() = '`';
    const std::size_t begin = docs.find(heading);
    ASSERT_NE(begin, std::string::npos) << heading;
    const std::string section = docs.substr(begin, docs.find("## ", begin + 3) - begin);
    for (const ForeignName& foreign : foreign_names(model)) {
      EXPECT_THAT(section, HasSubstr(std::string(foreign.format) + " `" + std::string(foreign.name) + "`"));
    }
  }
  std::size_t sections = 0;
  for (std::size_t at = docs.find("## "); at != docs.npos; at = docs.find("## ", at + 3)) ++sections;
  EXPECT_EQ(sections, model_names().size()) << "a model that is no more";
}

}  // namespace
}  // namespace raybundle
