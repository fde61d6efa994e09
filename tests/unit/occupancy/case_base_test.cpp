// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/occupancy/case_base.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "raybundle/geometry/error.hpp"
#include "raybundle/occupancy/learn.hpp"
#include "raybundle/synthetic/random.hpp"

namespace raybundle {
namespace {

const LearnOptions kQuick{.layers = {8, 2}, .steps = 300, .dropout = 0.0};

// Two classes, 3 apart along the first attribute; the second attribute is a hundred times as large and says nothing.
LabelledCases two_clouds(int cases, std::uint64_t seed) {
  LabelledCases labelled{.attribute_set = "test",
                         .situations = {{.name = "left"}, {.name = "right"}},
                         .group_names = {"all"},
                         .attributes = {},
                         .classes = {},
                         .actions = {}};
  labelled.attributes.resize(2, cases);
  Random random(seed);
  for (int n = 0; n < cases; ++n) {
    const int side = n % 2;
    labelled.attributes.col(n) << 3.0 * side + 0.3 * random.normal(), 100.0 * random.normal();
    labelled.classes.push_back(static_cast<std::uint8_t>(side));
    labelled.actions.push_back(side == 0 ? AirbagAction::kNoFire : AirbagAction::kFire);
  }
  return labelled;
}

// The same, so near to each other that some cases lie among those of the other class.
LabelledCases two_clouds_that_meet(int cases, std::uint64_t seed) {
  LabelledCases labelled = two_clouds(cases, seed);
  Random random(seed, 1);
  for (int n = 0; n < cases; ++n) labelled.attributes(0, n) += 1.0 * random.normal();
  return labelled;
}

// The embedding makes up for attributes of different size: raw distances would be decided by the second one alone.
TEST(CaseBase, LearntSpaceIgnoresWhatVariesWithinClasses) {
  const CaseBase base = learn(two_clouds(400, 1), kQuick);
  const LabelledCases others = two_clouds(400, 2);
  int right = 0, known = 0;
  for (int n = 0; n < 400; ++n) {
    const CaseVerdict verdict = classify(base, others.attributes.col(n));
    known += verdict.known;
    right += verdict.known && verdict.best == others.classes[n];
  }
  EXPECT_EQ(right, known);  // the classes are ten sigma apart
  EXPECT_GE(known, 385);    // known_share and a little for the edges that 400 cases do not reach
}

TEST(CaseBase, WhatIsFarFromAllCasesIsUnknown) {
  const CaseBase base = learn(two_clouds(400, 1), kQuick);
  EXPECT_FALSE(classify(base, Eigen::Vector2d(-9.0, 0.0)).known);
  EXPECT_FALSE(classify(base, Eigen::Vector2d(std::nan(""), 0.0)).known);
}

TEST(CaseBase, ACaseIsNotItsOwnNeighbour) {
  CaseBase base = learn(two_clouds(60, 3), kQuick);
  base.neighbours = 1;
  EXPECT_GT(distance_to_others(base, base.spaces[0], 5), 0.0);
}

// An action is only as allowed as the most doubtful of the spaces says.
TEST(CaseBase, SpacesThatDisagreeAreNotSure) {
  CaseBase base = learn(two_clouds(400, 1), kQuick);
  for (CaseSpace& space : base.spaces) space.farthest = 1e9;
  const auto fire = static_cast<std::size_t>(AirbagAction::kFire);
  const Eigen::Vector2d right(3.0, 0.0);
  EXPECT_DOUBLE_EQ(classify(base, right).allowed_least[fire], 1.0);
  base.spaces[1].embedding.centre[0] += 3.0F;  // it takes what is right for left
  EXPECT_LT(classify(base, right).allowed_least[fire], 0.5);
  EXPECT_GT(classify(base, right).action_votes[fire], 0.5);
}

TEST(CaseBase, OnlyCasesThatWereNotLearntFromVote) {
  LabelledCases cases = two_clouds(400, 5);
  cases.voting = 100;
  const CaseBase base = learn(cases, kQuick);
  EXPECT_EQ(base.classes, std::vector<std::uint8_t>(cases.classes.end() - 100, cases.classes.end()));
  EXPECT_EQ(base.spaces[0].cases.cols(), 100);
  const EmbeddedPlace first = base.spaces[0].embedding.place(cases.attributes.col(300));
  EXPECT_EQ(base.spaces[0].cases(0, 0), first[0]);
  cases.voting = 400;
  EXPECT_THROW(learn(cases, kQuick), Error);
}

// The law of sure_of_situation, on cases that nothing was set by. 1 % is three deviations of 2000 answers' share.
TEST(CaseBase, WhatIsToldIsRightWithTheWantedShare) {
  LabelledCases cases = two_clouds_that_meet(6000, 6);
  cases.voting = 3000;
  LearnOptions options = kQuick;
  options.right_situations = 0.97;
  const CaseBase base = learn(cases, options);
  const LabelledCases others = two_clouds_that_meet(3000, 7);
  int told = 0, right = 0, all_right = 0;
  for (int n = 0; n < 3000; ++n) {
    const CaseVerdict verdict = classify(base, others.attributes.col(n));
    const bool is_right = verdict.best == others.classes[n];
    all_right += is_right;
    if (verdict.votes[verdict.best] < base.sure_of_situation) continue;
    ++told;
    right += is_right;
  }
  EXPECT_LT(all_right, 0.95 * 3000);  // else the law would be empty
  EXPECT_GT(told, 2000);
  EXPECT_GE(right, (0.97 - 0.01) * told);
}

TEST(CaseBase, TheBaseDoesNotDependOnTheThreads) {
  LearnOptions options = kQuick;
  const CaseBase one = learn(two_clouds(200, 8), options);
  options.threads = 3;
  const CaseBase three = learn(two_clouds(200, 8), options);
  for (std::size_t s = 0; s < one.spaces.size(); ++s) EXPECT_EQ(one.spaces[s].cases, three.spaces[s].cases);
}

TEST(CaseBase, TooFewCasesOfAClassAreRefused) {
  LabelledCases cases = two_clouds(40, 4);
  std::ranges::fill(cases.classes, std::uint8_t{0});
  EXPECT_THROW(learn(cases, kQuick), Error);
}

TEST(CaseBase, SizesThatDoNotAgreeAreRefused) {
  CaseBase base = learn(two_clouds(80, 4), kQuick);
  base.classes.pop_back();
  EXPECT_THROW(base.check(), Error);
}

}  // namespace
}  // namespace raybundle
