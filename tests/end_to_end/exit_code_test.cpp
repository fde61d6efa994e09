// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "exit_code.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <tuple>

#include "program.hpp"

namespace raybundle::testing {
namespace {

// Scripts stand on the numbers: those that --help names.
TEST(ExitCode, OfEveryKindOfErrorIsTheOneThatHelpNames) {
  const std::vector<std::tuple<int, int, std::string>> table{
      {apps::kDone, 0, "done"},
      {apps::kGateFailed, 1, "a quality gate failed"},
      {apps::exit_code(ErrorKind::kBadInput), 2, "wrong usage"},
      {apps::exit_code(ErrorKind::kNotEnoughData), 3, "not enough usable data"},
      {apps::exit_code(ErrorKind::kSolveFailed), 4, "the solve failed"},
      {apps::exit_code(ErrorKind::kIo), 5, "reading or writing failed"}};
  ProgramRun help = raybundle_program({"--help"});
  EXPECT_EQ(help.exit_code, 0);
  std::ranges::replace(help.out, '\n', ' ');  // wherever lines are broken
  for (const auto& [code, number, meaning] : table) {
    EXPECT_EQ(code, number) << meaning;
    EXPECT_THAT(help.out, ::testing::HasSubstr(fmt::format("{} {}", number, meaning)));
  }
}

}  // namespace
}  // namespace raybundle::testing
