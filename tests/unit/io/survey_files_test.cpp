// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/io/survey_files.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "raybundle/geometry/error.hpp"

namespace raybundle {
namespace {

const Geodetic kOrigin{43.5642, 1.4811, 196.0};

std::string sentence(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(Survey, ReadsTheThreeKindsOfLandmarks) {
  const auto geodetic = landmarks_from_csv_text("name,lat,lon,height,sigma\ntower,43.5642,1.4811,246,0.02\n", "l.csv",
                                                kOrigin, HeightDatum{});
  EXPECT_LT((geodetic.at(0).x_in_local - Eigen::Vector3d(0, 0, 50)).norm(), 1e-9);
  const auto local = landmarks_from_csv_text("name,east,north,up,sigma\nmast,10,20,30,0.1\n", "l.csv", {}, {});
  EXPECT_EQ(local.at(0).x_in_local, Eigen::Vector3d(10, 20, 30));
  const auto far = landmarks_from_csv_text("name,azimuth,elevation,sigma\nstar,90,0,0.001\n", "l.csv", {}, {});
  EXPECT_TRUE(far.at(0).infinitely_far);
  EXPECT_LT((far.at(0).x_in_local - Eigen::Vector3d::UnitX()).norm(), 1e-15);
}

TEST(Survey, HeightsAboveTheSeaAreMovedByTheGeoid) {
  const auto landmarks = landmarks_from_csv_text("name,lat,lon,height,sigma\ntower,43.5642,1.4811,196,0\n", "l.csv",
                                                 kOrigin, height_datum_from_word("orthometric:49.5"));
  EXPECT_NEAR(landmarks.at(0).x_in_local.z(), 49.5, 1e-9);
}

TEST(Survey, HeightsOfUnknownDatumAreRefused) {
  EXPECT_THAT(sentence([] { landmarks_from_csv_text("name,lat,lon,height,sigma\na,1,2,3,0\n", "l.csv", kOrigin, {}); }),
              testing::HasSubstr("--height ellipsoidal"));
  EXPECT_THAT(sentence([] { height_datum_from_word("sea"); }), testing::HasSubstr("orthometric:47.3"));
  EXPECT_THAT(sentence([] { height_datum_from_word("orthometric:47.3m"); }), testing::HasSubstr("orthometric:47.3"));
}

TEST(Survey, BadTablesAreNamedByLine) {
  const auto local = [](const std::string& rows) {
    return sentence([&] { landmarks_from_csv_text("name,east,north,up,sigma\n" + rows, "l.csv", {}, {}); });
  };
  EXPECT_THAT(local("a,1,2,3,-1\n"), testing::HasSubstr("l.csv:2"));
  EXPECT_THAT(local("a,1,2,3,1\na,1,2,3,1\n"), testing::HasSubstr("stands twice"));
  EXPECT_THAT(local(""), testing::HasSubstr("no landmarks"));
  EXPECT_THAT(sentence([] { landmarks_from_csv_text("a,1,2,3\n", "l.csv", {}, {}); }),
              testing::HasSubstr("first line"));
  const std::vector<Landmark> tower{{"tower", {}, false, 0.0}};
  EXPECT_THAT(sentence([&] { sightings_from_csv_text("image,u,v,name\na.png,1,2,towr\n", "s.csv", tower); }),
              testing::HasSubstr("tower"));
}

}  // namespace
}  // namespace raybundle
