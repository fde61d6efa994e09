// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "raybundle/geometry/error.hpp"
#include "raybundle/scene/csv.hpp"
#include "raybundle/scene/suggestion.hpp"
#include "raybundle/synthetic/rig.hpp"
#include "raybundle/toml/toml_reader.hpp"

namespace raybundle {
namespace {

constexpr double kRadian = M_PI / 180.0;
constexpr int kLargestImage_px = 16384;
constexpr int kMostBeams = 64;  // each way

// A place on the rig: position, and turns about the rig's x, then y, then z axis.
Rigid3 rig_from_part(TomlReader& reader) {
  const Eigen::Vector3d turned = kRadian * vector3(reader, "turned_deg", Eigen::Vector3d::Zero());
  const Eigen::Quaterniond rotation(Eigen::AngleAxisd(turned.z(), Eigen::Vector3d::UnitZ()) *
                                    Eigen::AngleAxisd(turned.y(), Eigen::Vector3d::UnitY()) *
                                    Eigen::AngleAxisd(turned.x(), Eigen::Vector3d::UnitX()));
  return {rotation.normalized(), vector3(reader, "position_m", Eigen::Vector3d::Zero())};
}

Camera camera_from(TomlReader& reader) {
  const std::string name = reader.text("model");
  const auto model = model_named(name);
  if (!model) {
    std::vector<std::string> known;
    for (const std::string_view each : model_names()) known.emplace_back(each);
    reader.fail(nullptr, fmt::format("there is no camera model '{}'.{}", name, did_you_mean(name, known)));
  }
  const int width = reader.whole("width", 16, kLargestImage_px), height = reader.whole("height", 16, kLargestImage_px);
  auto parameters = reader.table("parameters", "parameters");
  if (!parameters) reader.fail(nullptr, "[[camera]] needs 'parameters', as { fx = 282.0, fy = 282.0, ... }");
  const std::vector<std::string_view> names = parameter_names(*model);
  Camera camera{*model, {width, height}, Eigen::VectorXd(static_cast<Eigen::Index>(names.size()))};
  for (std::size_t k = 0; k < names.size(); ++k) {
    const std::string key(names[k]);
    camera.parameters[static_cast<Eigen::Index>(k)] = k < 2 ? parameters->positive(key) : parameters->number(key);
  }
  parameters->refuse_unknown_keys();
  return camera;
}

SimulatedSensor sensor_from(TomlReader& reader) {
  SimulatedSensor sensor;
  if (reader.has("bits")) sensor.bits = reader.whole("bits", 8, 12);
  if (sensor.bits % 2 != 0) reader.fail(nullptr, "[[camera]].bits must be 8, 10 or 12");
  sensor.full_well_e = reader.positive("full_well_e", sensor.full_well_e);
  sensor.read_noise_e = reader.at_least_zero("read_noise_e", sensor.read_noise_e);
  sensor.black_level = reader.share("black_level", sensor.black_level);
  sensor.exposure = reader.positive("exposure", sensor.exposure);
  sensor.white_W_m2 = reader.positive("white_W_m2", sensor.white_W_m2);
  sensor.lens_blur_px = reader.at_least_zero("lens_blur_px", sensor.lens_blur_px);
  sensor.vignetting = reader.at_least_zero("vignetting", sensor.vignetting);
  return sensor;
}

SimulatedCamera rig_camera_from(TomlReader& reader, bool first) {
  SimulatedCamera camera;
  camera.name = reader.text("name");
  camera.camera = camera_from(reader);
  if (first && (reader.has("position_m") || reader.has("turned_deg"))) {
    reader.fail(nullptr, "the first camera's frame is the rig frame: leave out its position_m and turned_deg");
  }
  if (!first) camera.camera_from_rig = rig_from_part(reader).inverse();
  const double used_field_deg = reader.positive("used_field_deg", 360.0);
  camera.used_half_angle_rad = std::min(0.5 * used_field_deg * kRadian, max_angle_rad(camera.camera));
  camera.sensor = sensor_from(reader);
  reader.refuse_unknown_keys();
  return camera;
}

SpreadingLens lens_from(TomlReader& reader) {
  SpreadingLens lens;
  lens.index = reader.positive("index", lens.index);
  if (!(lens.index > 1)) reader.fail(nullptr, "[emitter.lens].index must be above 1");
  if (reader.has("radius_m") == reader.has("focal_length_m")) {
    reader.fail(nullptr, "[emitter.lens] needs one of radius_m and focal_length_m (both positive)");
  }
  lens.radius_m =
      reader.has("radius_m") ? reader.positive("radius_m") : reader.positive("focal_length_m") * (lens.index - 1.0);
  lens.distance_m = reader.positive("distance_m");
  lens.thickness_m = reader.positive("thickness_m", lens.thickness_m);
  if (reader.has("concave")) {
    const std::string side = reader.text("concave");
    if (side != "inside" && side != "outside") {
      reader.fail(nullptr, "[emitter.lens].concave must be \"inside\" (towards the grating) or \"outside\"");
    }
    lens.concave_inside = side == "inside";
  }
  if (reader.has("offset_m")) lens.offset_m = Eigen::Vector2d(reader.numbers("offset_m", 2).data());
  reader.refuse_unknown_keys();
  return lens;
}

void read_periods(TomlReader& reader, Emitter& emitter) {
  if (reader.has("field_deg") == reader.has("column_period_m")) {
    reader.fail(nullptr,
                "[emitter] needs one of field_deg = [90.0, 70.0] (between the outermost columns and rows) and "
                "column_period_m with row_period_m");
  }
  if (reader.has("field_deg")) {
    const std::vector<double> field = reader.numbers("field_deg", 2);
    try {
      set_periods_from_field(emitter, kRadian * Eigen::Vector2d(field.data()));
    } catch (const Error& error) {
      reader.fail(nullptr, error.what());
    }
    return;
  }
  emitter.column_period_m = reader.positive("column_period_m");
  emitter.row_period_m = reader.positive("row_period_m");
}

void read_missing(TomlReader& reader, Emitter& emitter) {
  for (const std::vector<double>& pair : reader.rows_of_numbers("missing", 2)) {
    const int row = static_cast<int>(pair[0]), column = static_cast<int>(pair[1]);
    if (row != pair[0] || column != pair[1] || row < 0 || row >= emitter.grid.rows || column < 0 ||
        column >= emitter.grid.columns) {
      reader.fail(nullptr, fmt::format("[emitter].missing holds [{}, {}], which is no [row, column] of the {}x{} beams",
                                       pair[0], pair[1], emitter.grid.rows, emitter.grid.columns));
    }
    emitter.missing.emplace_back(row, column);
  }
}

Emitter emitter_from(TomlReader& reader) {
  Emitter emitter;
  emitter.grid = {reader.whole("rows", 1, kMostBeams), reader.whole("columns", 1, kMostBeams)};
  emitter.wavelength_m = reader.positive("wavelength_m", emitter.wavelength_m);
  emitter.zero_order_row = reader.number("zero_order_row", 0.5 * (emitter.grid.rows - 1));
  emitter.zero_order_column = reader.number("zero_order_column", 0.5 * (emitter.grid.columns - 1));
  emitter.zero_order_power = reader.at_least_zero("zero_order_power", emitter.zero_order_power);
  emitter.lattice_turn_rad = kRadian * reader.number("lattice_turn_deg", 0.0);
  emitter.rig_from_emitter = rig_from_part(reader);
  if (auto lens = reader.table("lens", "[emitter.lens]")) emitter.lens = lens_from(*lens);
  read_periods(reader, emitter);
  read_missing(reader, emitter);
  emitter.beam_power_W = reader.positive("beam_power_W", emitter.beam_power_W);
  emitter.spot_radius_m = reader.positive("spot_radius_m", emitter.spot_radius_m);
  emitter.waist_distance_m = reader.number("waist_distance_m", emitter.waist_distance_m);
  emitter.divergence_rad = reader.at_least_zero("divergence_rad", emitter.divergence_rad);
  emitter.speckle_contrast = reader.share("speckle_contrast", emitter.speckle_contrast);
  emitter.wavelength_drift_m_K = reader.number("wavelength_drift_m_K", emitter.wavelength_drift_m_K);
  reader.refuse_unknown_keys();
  try {
    beams_of(emitter);
  } catch (const Error& error) {
    reader.fail(nullptr, error.what());
  }
  return emitter;
}

void read_board(TomlReader& reader, SimulatedBoard& board) {
  board.shape = {reader.number("bend_x_m", 0.0), reader.number("bend_y_m", 0.0), reader.number("twist_m", 0.0)};
  board.paper_albedo = reader.share("paper_albedo", board.paper_albedo);
  board.ink_albedo = reader.share("ink_albedo", board.ink_albedo);
  const double margin = reader.at_least_zero("margin_m", 0.0);
  board.print.sheet.low.array() -= margin;
  board.print.sheet.high.array() += margin;
  reader.refuse_unknown_keys();
}

SimulatedLight light_from(TomlReader& reader) {
  SimulatedLight light;
  light.ambient_W_m2 = reader.at_least_zero("ambient_W_m2", light.ambient_W_m2);
  light.sun_W_m2 = reader.at_least_zero("sun_W_m2", light.sun_W_m2);
  light.sun_direction = vector3(reader, "sun_direction", light.sun_direction);
  if (!(light.sun_direction.norm() > 0)) reader.fail(nullptr, "[light].sun_direction has no length");
  light.background_albedo = reader.share("background_albedo", light.background_albedo);
  light.background_m = reader.positive("background_m", light.background_m);
  reader.refuse_unknown_keys();
  return light;
}

PoseRange poses_from(TomlReader& reader) {
  PoseRange poses;
  if (reader.has("distance_m")) {
    const std::vector<double> range = reader.numbers("distance_m", 2);
    if (!(range[0] > 0 && range[1] >= range[0])) reader.fail(nullptr, "[poses].distance_m must be [nearest, farthest]");
    poses.min_distance_m = range[0];
    poses.max_distance_m = range[1];
  }
  const auto angle = [&](const std::string& key, double fallback_rad, double limit_deg) {
    const double degrees = reader.at_least_zero(key, fallback_rad / kRadian);
    if (degrees > limit_deg) reader.fail(nullptr, fmt::format("[poses].{} must be 0 to {}", key, limit_deg));
    return degrees * kRadian;
  };
  poses.max_tilt_rad = angle("tilt_deg", poses.max_tilt_rad, 85.0);
  poses.max_roll_rad = angle("roll_deg", poses.max_roll_rad, 180.0);
  poses.whole_board = reader.flag("whole_board", poses.whole_board);
  reader.refuse_unknown_keys();
  return poses;
}

std::vector<SimulatedCamera> cameras_from(TomlReader& root) {
  std::vector<SimulatedCamera> cameras;
  std::set<std::string> names;
  for (TomlReader& reader : root.tables("camera")) {
    cameras.push_back(rig_camera_from(reader, cameras.empty()));
    if (!names.insert(cameras.back().name).second) {
      reader.fail(nullptr, fmt::format("two cameras are called '{}'; rename one", cameras.back().name));
    }
  }
  if (cameras.empty()) root.fail(nullptr, "there is no [[camera]]; a rig has at least one");
  return cameras;
}

}  // namespace

SimulatedBoard simulated_chessboard(int columns, int rows, double square_m) {
  SimulatedBoard board;
  board.target.name = "board";
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      board.target.points.push_back({row * columns + column, {column * square_m, row * square_m, 0}});
    }
  }
  const auto corner = [square_m](int column, int row) {
    return Eigen::Vector2d((column - 1) * square_m, (row - 1) * square_m);
  };
  for (int row = 0; row <= rows; ++row) {
    for (int column = row % 2; column <= columns; column += 2) {
      board.print.boxes.push_back({corner(column, row), corner(column + 1, row + 1)});
    }
  }
  board.print.sheet = {corner(0, 0), corner(columns + 1, rows + 1)};
  return board;
}

SimulatedBoard chessboard_from_text(const std::string& text, const std::string& file) {
  const toml::table table = toml_from_text(text, file);
  TomlReader root(table, "the file", file);
  auto reader = root.table("target", "[target]");
  if (!reader) root.fail(nullptr, "there is no [target] section, which describes the board");
  const std::string kind = reader->text("kind");
  if (kind != "chessboard") {
    reader->fail(nullptr, fmt::format("'{}' is not printed here, only a chessboard is; `raybundle simulate` knows all "
                                      "kinds of boards",
                                      kind));
  }
  constexpr int kMostCorners = 1000;
  const int columns = reader->whole("columns", 2, kMostCorners), rows = reader->whole("rows", 2, kMostCorners);
  SimulatedBoard board = simulated_chessboard(columns, rows, reader->positive("square_m"));
  reader->refuse_unknown_keys();
  return board;
}

SimulatedRig rig_from_text(std::string_view text, const std::string& file, const BoardReader& board_reader) {
  const toml::table table = toml_from_text(text, file);
  TomlReader root(table, "the rig", file);
  SimulatedRig rig;
  rig.cameras = cameras_from(root);
  root.table("target", "[target]");
  rig.board = board_reader(std::string(text), file);
  if (auto reader = root.table("emitter", "[emitter]")) rig.emitter = emitter_from(*reader);
  if (auto reader = root.table("board", "[board]")) read_board(*reader, rig.board);
  if (auto reader = root.table("light", "[light]")) rig.light = light_from(*reader);
  if (auto reader = root.table("poses", "[poses]")) rig.poses = poses_from(*reader);
  root.refuse_unknown_keys();
  return rig;
}

SimulatedRig read_rig(const std::filesystem::path& path, const BoardReader& board_reader) {
  return rig_from_text(text_of_file(path), path.string(), board_reader);
}

}  // namespace raybundle
