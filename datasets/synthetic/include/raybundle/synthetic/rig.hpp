// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "raybundle/camera/camera.hpp"
#include "raybundle/geometry/rigid3.hpp"
#include "raybundle/scene/target.hpp"
#include "raybundle/synthetic/emitter.hpp"

namespace raybundle {

/// What a camera makes of the light, for images.
struct SimulatedSensor {
  int bits = 8;                ///< 8, 10 or 12
  double full_well_e = 10000;  ///< electrons of the largest grey value
  double read_noise_e = 8;     ///< standard deviation
  double black_level = 0.03;   ///< grey value without light, as a share of the range
  double exposure = 1.0;       ///< time, over that at which white_W_m2 on a white surface fills the range
  double white_W_m2 = 8.0;     ///< see exposure
  double lens_blur_px = 0.5;   ///< standard deviation of the lens's spot, each axis
  double vignetting = 3.0;     ///< light falls off with cos(angle / 2) to this power
};

/// A camera of a simulated rig.
struct SimulatedCamera {
  std::string name;
  Camera camera;
  Rigid3 camera_from_rig;             ///< of the first camera: the identity
  double used_half_angle_rad = M_PI;  ///< nothing is measured farther off the axis
  SimulatedSensor sensor;
};

/// What is printed on a board, in the target's x and y [m]. Boxes do not overlap, but touch.
struct BoardPrint {
  struct Box {
    Eigen::Vector2d low, high;
  };
  struct Disc {
    Eigen::Vector2d centre;
    double radius = 0.0;
  };
  Box sheet{{0, 0}, {0, 0}};  ///< what the board is cut to
  std::vector<Box> boxes;
  std::vector<Disc> discs;
  std::optional<Box> ground;  ///< of an inverted print: inked here, white in boxes and discs
  double front = -1.0;        ///< the printed side looks along this sign of the target's z
};

/// The board that is moved in front of the rig.
struct SimulatedBoard {
  Target target;
  BoardPrint print;
  BoardShape shape;
  double paper_albedo = 0.85;
  double ink_albedo = 0.25;  ///< in the near infrared many inks are far from black
};

/// Light that does not come from the emitter, within the band that the cameras see.
struct SimulatedLight {
  double ambient_W_m2 = 2.0;                                          ///< from everywhere
  double sun_W_m2 = 0.0;                                              ///< on a surface that faces the sun
  Eigen::Vector3d sun_direction = Eigen::Vector3d(-0.5, -0.7, -0.5);  ///< towards the sun, in the rig frame
  double background_albedo = 0.15;                                    ///< of what is behind the board
  double background_m = 3.0;  ///< distance of what is behind the board from the rig, all around; beams light it too
};

/// How the board is held.
struct PoseRange {
  double min_distance_m = 0.25;  ///< from the rig to the place on the board that is aimed at
  double max_distance_m = 1.3;
  double max_tilt_rad = 50 * M_PI / 180;  ///< of the board against the line of sight
  double max_roll_rad = 30 * M_PI / 180;  ///< about its normal
  bool whole_board = true;                ///< at least one camera sees all points: most detectors need it
};

/// A rig whose every property is known. The first camera's frame is the rig frame.
struct SimulatedRig {
  std::vector<SimulatedCamera> cameras;
  std::optional<Emitter> emitter;
  SimulatedBoard board;
  SimulatedLight light;
  PoseRange poses;
};

/// Makes target and print, without a margin, of the [target] section of a text in TOML.
///
/// @param file  name of the text, for messages
using BoardReader = std::function<SimulatedBoard(const std::string& text, const std::string& file)>;

/// The BoardReader for kind = "chessboard", with columns, rows and square_m.
SimulatedBoard chessboard_from_text(const std::string& text, const std::string& file);

/// A chessboard of columns × rows inner corners, cut to its squares.
SimulatedBoard simulated_chessboard(int columns, int rows, double square_m);

/// Reads a rig description. The format: docs/formats/rig.md; examples: datasets/rigs.
///
/// @throws Error(kIo) when it cannot be read; Error(kBadInput) `file:line: ...` naming the field
SimulatedRig read_rig(const std::filesystem::path& path, const BoardReader& board_reader = chessboard_from_text);
SimulatedRig rig_from_text(std::string_view text, const std::string& file,
                           const BoardReader& board_reader = chessboard_from_text);

/// A rig drawn at random: one or two cameras of any model of the list, an emitter, a chessboard, all of them plausible.
SimulatedRig random_rig(std::uint64_t seed);

}  // namespace raybundle
