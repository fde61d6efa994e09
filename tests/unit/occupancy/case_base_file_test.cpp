// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/occupancy/case_base_file.hpp"

#include <gtest/gtest.h>

#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

CaseBase small_base() {
  CaseBase base{.attribute_set = "test",
                .situations = {{.name = "empty", .inert = true}, {.name = "adult"}},
                .group_names = {"nobody", "somebody"},
                .spaces = {{.embedding = {.centre = Eigen::Vector3f(1, 2, 3),
                                          .scale = Eigen::Vector3f(1, 2, 3),
                                          .layers = {{Eigen::MatrixXf::Random(4, 3), Eigen::VectorXf::Random(4)},
                                                     {Eigen::MatrixXf::Random(2, 4), Eigen::VectorXf::Random(2)}}},
                            .cases = Eigen::MatrixXf::Random(2, 5),
                            .farthest = 1.5}},
                .classes = {0, 1, 0, 1, 1},
                .actions = {AirbagAction::kNoFire, AirbagAction::kFire, AirbagAction::kNoFire, AirbagAction::kFire,
                            AirbagAction::kDepowered},
                .neighbours = 3};
  base.situations[1].group = 1;
  return base;
}

TEST(CaseBaseFile, BringsBackTheSameBits) {
  const CaseBase base = small_base();
  const std::string bytes = bytes_from_case_base(base);
  const CaseBase back = case_base_from_bytes(bytes, "base");
  EXPECT_EQ(bytes_from_case_base(back), bytes);
  EXPECT_EQ(back.spaces[0].cases, base.spaces[0].cases);
  EXPECT_EQ(back.spaces[0].embedding.layers[0].weights, base.spaces[0].embedding.layers[0].weights);
  EXPECT_EQ(back.situations[1].name, "adult");
  EXPECT_EQ(back.actions, base.actions);
  EXPECT_TRUE(back.situations[0].inert);
}

// A device must not decide by a damaged base, however small the damage.
TEST(CaseBaseFile, EveryFlippedBitAndEveryTruncationIsRefused) {
  const std::string bytes = bytes_from_case_base(small_base());
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    std::string damaged = bytes;
    damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << (bit % 8)));
    EXPECT_THROW(case_base_from_bytes(damaged, "base"), Error) << "bit " << bit;
  }
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    EXPECT_THROW(case_base_from_bytes(std::string_view(bytes).substr(0, length), "base"), Error) << length;
  }
}

TEST(CaseBaseFile, SaysWhichFileIsDamagedAndHowToMakeItAgain) {
  const std::string bytes = bytes_from_case_base(small_base());
  std::string payload(checked_payload(kCaseBaseKind, bytes, "base"));
  const auto complaint = [](const std::string& content) -> std::string {
    try {
      case_base_from_bytes(checked_file(kCaseBaseKind, content), "cabin.rbcases");
      return "none";
    } catch (const Error& error) {
      return error.what();
    }
  };
  EXPECT_EQ(complaint(payload.substr(0, payload.size() - 1)),
            "cabin.rbcases: holds no sensible value for a list; make it again with `raybundle occupancy learn`");
  payload.back() = 9;  // the action of the last case
  EXPECT_EQ(complaint(payload),
            "cabin.rbcases: the base of learnt cases is damaged: a case has no right action; learn it again");
}

TEST(CaseBaseFile, ContentThatDoesNotAgreeIsNotWritten) {
  CaseBase base = small_base();
  base.situations[1].group = 2;
  EXPECT_THROW(bytes_from_case_base(base), Error);
}

}  // namespace
}  // namespace raybundle
