// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include "detect_images.hpp"
#include "program.hpp"
#include "raybundle/geometry/error.hpp"
#include "synthetic_world.hpp"
#include "tables.hpp"

namespace raybundle::testing {
namespace {

using ::testing::HasSubstr;

/// Images of one board and what `detect` must find in them. Where the corners are is left to the calibrations.
struct ImageSet {
  const char* name;
  const char* folder;  ///< in the real data
  const char* images;  ///< pattern in the folder
  const char* board;
  int boards;   ///< images that must give a board ...
  int corners;  ///< ... of at least so many corners
};

void PrintTo(const ImageSet& set, std::ostream* out) { *out << set.folder << ", " << set.board; }

class Detects : public ::testing::TestWithParam<ImageSet> {};

TEST_P(Detects, TheBoard) {
  const ImageSet& set = GetParam();
  RAYBUNDLE_NEEDS_DATA(set.folder);
  const std::string images = (real_data(set.folder) / set.images).string();
  const nlohmann::json found = detect(fresh_folder(), {"--target", set.board, "--camera", "camera=" + images});
  ASSERT_TRUE(found.contains("views"));
  EXPECT_GE(views_with(found, "camera", set.corners), set.boards) << nlohmann::json(corners_by_frame(found)).dump(2);
  for (const auto& view : found.at("views")) {
    for (const auto& point : view.at("points")) EXPECT_GT(point.at(3), 0.0) << "every corner has its sigma";
  }
}

// Charuco images cut by the image's edge show about half of their 49 corners. Ocam's 190 degree board is 7x6 inner
// corners as printed; its owners used the 6x5 without the outermost, which therefore must be read as well.
INSTANTIATE_TEST_SUITE_P(
    Chessboards, Detects,
    ::testing::Values(
        ImageSet{"sourishg_left", "sourishg_fisheye_stereo/imgs", "left*.jpg", "chessboard:9x6:24.23mm", 29, 30},
        ImageSet{"sourishg_right", "sourishg_fisheye_stereo/imgs", "right*.jpg", "chessboard:9x6:24.23mm", 29, 30},
        ImageSet{"camodocal", "camodocal_fisheye/images", "*.png", "chessboard:9x6:120mm", 62, 30},
        ImageSet{"ocam_1", "ocam/Fisheye1", "*.jpg", "chessboard:8x6:32.5mm", 15, 40},
        ImageSet{"ocam_190_visible", "ocam/Fisheye190deg", "*.jpg", "chessboard:7x6:30mm", 7, 28},
        ImageSet{"ocam_190_stated", "ocam/Fisheye190deg", "*.jpg", "chessboard:6x5:30mm", 7, 25},
        ImageSet{"opencv_left", "opencv_stereo_chess", "left*.jpg", "chessboard:9x6:25mm", 13, 54},
        ImageSet{"opencv_right", "opencv_stereo_chess", "right*.jpg", "chessboard:9x6:25mm", 13, 54},
        ImageSet{"boofcv_left", "boofcv_stereo/Bumblebee2_Chess", "left*.jpg", "chessboard:6x4:30mm", 11, 24},
        ImageSet{"boofcv_right", "boofcv_stereo/Bumblebee2_Chess", "right*.jpg", "chessboard:6x4:30mm", 11, 24}),
    [](const auto& set) { return set.param.name; });

// Tags have four corners each: in "top", 19 of 36 tags are found by others, the rest lie near the lens's dark rim.
INSTANTIATE_TEST_SUITE_P(
    AprilGrids, Detects,
    ::testing::Values(
        ImageSet{"tum_vi", "aprilgrid_rs/tests_data", "TUM_VI.png", "aprilgrid:6x6:88mm:0.3", 1, 4 * 36},
        ImageSet{"r45", "aprilgrid_rs/tests_data", "r45.png", "aprilgrid:6x6:88mm:0.3", 1, 4 * 36},
        ImageSet{"tum_vi_data", "aprilgrid_rs/data", "*.png", "aprilgrid:6x6:88mm:0.3", 1, 4 * 36},
        ImageSet{"euroc", "aprilgrid_rs/tests_data", "EuRoC.png", "aprilgrid:6x6:88mm:0.3", 1, 4 * 35},
        ImageSet{"rim_right", "aprilgrid_rs/tests_data", "right.png", "aprilgrid:6x6:88mm:0.3", 1, 4 * 19},
        ImageSet{"rim_top", "aprilgrid_rs/tests_data", "top.png", "aprilgrid:6x6:88mm:0.3", 1, 4 * 19},
        ImageSet{"rim_corner", "aprilgrid_rs/tests_data", "top_right.png", "aprilgrid:6x6:88mm:0.3", 1, 4 * 14},
        ImageSet{"phone", "aprilgrid_rs/tests_data", "iphone.png", "aprilgrid:11x6:88mm:0.3", 1, 4 * 66}),
    [](const auto& set) { return set.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Charuco, Detects,
    ::testing::Values(ImageSet{"new_layout", "photonvision_charuco_small/lifecam_480", "*.jpg",
                               "charuco:8x8:25.4mm:19.05mm:DICT_4X4_1000", 17, 20},
                      ImageSet{"legacy_layout", "photonvision_charuco_small/lifecam_1280_old_pattern", "*.jpg",
                               "charuco:8x8:25.4mm:19.05mm:DICT_4X4_1000:legacy", 13, 20},
                      ImageSet{"inverted", "caliscope/charuco_calibration/calibration/extrinsic", "cam_2.mp4",
                               "charuco:4x5:54mm:40.5mm:DICT_4X4_1000:inverted", 37, 6}),
    [](const auto& set) { return set.param.name; });

// Nine tenths of the circles, as the unit tests of the detector ask.
// BoofCV's hexagonal grid counts half steps and looks up: our asymmetric grid that begins with its shifted row.
constexpr const char* kHexagonal = "asymmetric_circles:14x24:6mm:row_step=10.3923mm:first_row_shifted";

INSTANTIATE_TEST_SUITE_P(
    Circles, Detects,
    ::testing::Values(ImageSet{"regular", "boofcv_mono/Sony_DSC-HX5V_CircleRegular", "*.jpg", "circles:10x8:25mm", 6,
                               72},
                      ImageSet{"hexagonal", "boofcv_mono/Sony_DSC-HX5V_CircleHexagonal", "*.jpg", kHexagonal, 7, 302},
                      ImageSet{"visp", "visp_circlegrid", "grid36*.pgm", "circles:6x6:30mm", 4, 33},
                      ImageSet{"linelight", "linelight_zhao/calib_picture", "*.jpg", "circles:7x7:20mm", 12, 49}),
    [](const auto& set) { return set.param.name; });

TEST(DetectsTwoBoards, InOneImage) {
  RAYBUNDLE_NEEDS_DATA("aprilgrid_rs/tests_data");
  const std::filesystem::path place = fresh_folder();
  const std::string board = "[[target]]\nkind = \"aprilgrid\"\ncolumns = 6\nrows = 6\ntag_m = 0.088\nspacing = 0.3\n";
  write_text(place / "dataset.toml",
             board + board + "first_tag = 36\n[[camera]]\nname = \"c\"\nmodel = \"kannala_brandt\"\nimages = \"" +
                 (real_data("aprilgrid_rs/tests_data") / "two_boards.png").string() + "\"\n");
  const nlohmann::json found = detect(place, {(place / "dataset.toml").string()});
  int corners = 0;
  for (const auto& view : found.at("views")) corners += static_cast<int>(view.at("points").size());
  EXPECT_GE(corners, 4 * 72);
}

// The command that it ends with can be typed as it stands.
TEST(Detects, AndAsksForAModelOnlyWhereTheFileHoldsNone) {
  RAYBUNDLE_NEEDS_DATA("opencv_stereo_chess");
  const std::filesystem::path place = fresh_folder();
  std::vector<std::string> arguments{"detect",
                                     "--target",
                                     "chessboard:9x6:25mm",
                                     "--camera",
                                     "c=" + (real_data("opencv_stereo_chess") / "left0[1-3].jpg").string(),
                                     "-o",
                                     (place / "o.json").string()};
  EXPECT_THAT(raybundle_program(arguments).out, HasSubstr("--model MODEL"));
  arguments.insert(arguments.end(), {"--model", "brown_conrady"});
  const ProgramRun run = raybundle_program(arguments);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("raybundle calibrate --observations"));
  EXPECT_THAT(run.out, ::testing::Not(HasSubstr("--model MODEL")));
}

TEST(Detects, AndPrintsWhatItWritesForOtherPrograms) {
  const std::filesystem::path folder = fresh_folder();
  write_text(folder / "corners.csv", csv_of(synthetic_world({}).problem));
  const ProgramRun run = raybundle_program({"detect", "--observations", (folder / "corners.csv").string(), "--target",
                                            "chessboard:9x7:40mm", "--image-size", "camera0=1280x960", "--json", "-o",
                                            (folder / "observations.json").string()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(nlohmann::json::parse(run.out), json_of(folder / "observations.json"));
}

TEST(DetectsNothing, OfTheOtherCharucoLayoutAndNamesTheSetting) {
  RAYBUNDLE_NEEDS_DATA("photonvision_charuco_small");
  const std::filesystem::path place = fresh_folder();
  for (const bool legacy : {true, false}) {
    const std::string folder = legacy ? "lifecam_1280_old_pattern" : "lifecam_480";
    const std::string images = (real_data("photonvision_charuco_small") / folder / "*.jpg").string();
    const std::string board = std::string("charuco:8x8:25.4mm:19.05mm:DICT_4X4_1000") + (legacy ? "" : ":legacy");
    const ProgramRun run =
        raybundle_program({"detect", "--target", board, "--camera", "c=" + images, "-o", (place / "o.json").string()});
    EXPECT_EQ(run.exit_code, 3);
    EXPECT_THAT(run.err, HasSubstr(legacy ? "legacy = true" : "legacy = false"));
  }
}

// In the reflection of a larger board, the one asked for may be found in a few images of many.
TEST(RequireViews, ABoardThatIsFoundNowAndThenBesideAnotherIsAMisreading) {
  apps::DetectedImages images;
  images.observations.problem.views.resize(3);
  images.unused.resize(6);
  EXPECT_NO_THROW(require_views(images));
  images.seen_sizes["9x6"] = 2;
  EXPECT_THROW(require_views(images), Error);
  images.unused.resize(2);  // most images show the board that was asked for
  EXPECT_NO_THROW(require_views(images));
  images.seen_sizes["9x6"] = 3;
  EXPECT_THROW(require_views(images), Error);
}

// One image was read as 10x7 once: nine corners in a row, and a stray one on the margin.
TEST(RequireViews, CountedSquaresAreNamedAndNoImageIsMisread) {
  const char* folder = "opencv_stereo_chess";
  RAYBUNDLE_NEEDS_DATA(folder);
  const ProgramRun run = raybundle_program({"calibrate", "--target", "chessboard:10x7:25mm", "--camera",
                                            "left=" + (real_data(folder) / "left[0-9]*.jpg").string(), "--model",
                                            "brown_conrady", "-o", (fresh_folder() / "out").string()});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_THAT(run.err, HasSubstr("error: no board was found in any of 13 images"));
  EXPECT_THAT(run.err, HasSubstr("did you count squares? chessboard:9x6:SQUARE would fit"));
}

}  // namespace
}  // namespace raybundle::testing
