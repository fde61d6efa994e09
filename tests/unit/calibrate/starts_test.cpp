// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0

// Random rigs on which calibrate() once came to a wrong optimum or refused wrongly, each for a reason of its own.
// `./dev prove starts` goes through many more.
#include <gtest/gtest.h>
#include <cstdint>

#include <string>

#include "start_verdict.hpp"

namespace raybundle::testing {
namespace {

struct HardRig {
  const char* name;
  const char* model;
  std::uint64_t seed;
  Verdict verdict = Verdict::kReached;  ///< a rig that was solved must not come to be refused unseen, nor the other way
};

class HardStart : public ::testing::TestWithParam<HardRig> {};

TEST_P(HardStart, ReachesTheOptimumOfTheTruthOrIsRefusedWhereItIsToBe) {
  const RandomRig rig = random_rig(*model_named(GetParam().model), GetParam().seed);
  const TruthStart truth = start_from_truth(rig);
  const Judgement judgement = judge_start(rig, truth);
  EXPECT_EQ(judgement.verdict, GetParam().verdict) << judgement.why << "; " << rig.story;
}

INSTANTIATE_TEST_SUITE_P(
    Rigs, HardStart,
    ::testing::Values(HardRig{"LensesWithAPoleCrowdOutNoOthers", "rational", 57},
                      HardRig{"AViewThatAPoleCostComesBack", "thin_prism", 87},
                      HardRig{"ALensMayFoldShortlyBeyondItsCorners", "rational", 2054},
                      HardRig{"TwoLensesFarApartMayFitAlike", "double_sphere", 2049},
                      HardRig{"AnOptimumMayLieFarOut", "unified", 2030},
                      HardRig{"CoefficientsAreGivenUpWhereNothingComesToRest", "rational", 2060},
                      HardRig{"WrongOnesAmongFewCornersDoNotHideTheLens", "thin_prism", 82},
                      HardRig{"PixelsThatAreNotSquareHideNoLens", "kannala_brandt", 3037},
                      HardRig{"BoardsHeldAlikeFitSeveralLenses", "kannala_brandt", 5014},
                      HardRig{"FarBoardsFitNearlyAnyLens", "brown_conrady", 7055},
                      HardRig{"TwoBoardsMayBothBeMirrored", "brown_conrady", 5114},
                      HardRig{"ANarrowBoardMayBeTurnedAboutItsLength", "field_of_view", 5101},
                      HardRig{"ThreeLensesMayBeNearlyAlike", "unified", 6193},
                      HardRig{"TheValleyIsSearchedToItsEnd", "double_sphere", 3044},
                      HardRig{"AViewWhereTheOthersShowNothingComesBack", "thin_prism", 8032},
                      HardRig{"AWrongPoseOfARightViewIsMended", "kannala_brandt", 9192},
                      HardRig{"AValleyIsFollowedAsFarAsItIsOpen", "kannala_brandt", 11064},
                      HardRig{"AllBoardsMayTurnWithTheLens", "thin_prism", 12085},
                      HardRig{"ALooseLensHasOptimaAlongWhatViewsDoNotTell", "thin_prism", 5175},
                      HardRig{"CornersTakenInAgainMayLeadElsewhere", "double_sphere", 15155},
                      HardRig{"AMirroredBoardMayBendTheLensForOthers", "brown_conrady", 16128},
                      HardRig{"AWrongCornerMayHoldTheLens", "field_of_view", 20637},
                      HardRig{"AWrongCornerOfFewTurnsItsBoard", "unified", 20363},
                      HardRig{"ALostViewFarFromTheOthersComesBack", "kannala_brandt", 11119},
                      HardRig{"ThreeLensesMayLieAlongOneValley", "double_sphere", 20220},
                      HardRig{"AViewThatComesBackMayLeadElsewhere", "double_sphere", 13098},
                      HardRig{"ALensNearlyRectilinearKeepsItsBeta", "extended_unified", 30649},
                      HardRig{"AViewPosedPoorlyComesBackInTheEnd", "brown_conrady", 22216},
                      HardRig{"AllCoefficientsAreTriedOnceMore", "thin_prism", 16056},
                      HardRig{"AViewThatComesBackMayBeMirrored", "pinhole", 30087},
                      HardRig{"ASolveThatIsBlockedSetsOutElsewhere", "extended_unified", 30278},
                      HardRig{"CoefficientsAreTakenBack", "rational", 41045},
                      HardRig{"FewCornersTellWhatFitsPlainlyWorse", "rational", 30489},
                      HardRig{"WrongCornersMayAgreeBetter", "field_of_view", 24161},
                      HardRig{"ALensGrowsToTheRimThatItLeftOut", "rational", 90154},
                      HardRig{"AGrownLensFitsBetter", "rational", 90349},
                      HardRig{"PriorsCountWhereLensesAreCompared", "rational", 90942},
                      HardRig{"StartsAreWeighedByTheirOwnPriors", "rational", 97534},
                      HardRig{"AGrownLensLiesElsewhereInTheValley", "thin_prism", 48025},
                      HardRig{"TheTrueLensMayBeTheOneElsewhere", "pinhole", 90766, Verdict::kRefusedRightly},
                      HardRig{"ABoardTurnsAboutALineOfItsCorners", "rational", 98188},
                      HardRig{"ABentBoardMayMoveThePoleAmongCorners", "thin_prism", 98010},
                      HardRig{"SixCornersOnALineDoNotPoseAView", "pinhole", 100267},
                      HardRig{"AWrongCornerMoreIsNotBetter", "rational", 100003},
                      HardRig{"ALensThatDoesNotReachACornerEndsBeforeIt", "thin_prism", 97178},
                      HardRig{"MoreThanThreeDirectionsMayBeWeak", "thin_prism", 98445},
                      HardRig{"AValleyMayBendUnderTheLastStep", "extended_unified", 110062},
                      HardRig{"ARightCornerMoreIsBetter", "extended_unified", 110208},
                      HardRig{"ParallelBoardsFitOtherFocalLengths", "kannala_brandt", 16005, Verdict::kRefusedRightly}),
    [](const auto& rig) { return std::string(rig.param.name); });

TEST(OpenStart, AnOpenOptimumIsRefused) {
  const RandomRig rig = random_rig(*model_named("unified"), 48099);
  const Judgement judgement = judge_start(rig, start_from_truth(rig));
  EXPECT_EQ(judgement.verdict, Verdict::kRefusedRightly) << judgement.why << "; " << rig.story;
}

}  // namespace
}  // namespace raybundle::testing
