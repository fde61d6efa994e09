// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/structured_light/table_file.hpp"

#include <cmath>

#include "raybundle/device/byte_stream.hpp"
#include "raybundle/device/checked_file.hpp"
#include "raybundle/scene/csv.hpp"

namespace raybundle {
namespace {

constexpr int kMostPixels = 1 << 15, kMostTests = 1 << 12;

template <typename Derived>
void put(ByteWriter& writer, const Eigen::MatrixBase<Derived>& matrix) {
  for (const double number : matrix.reshaped()) writer.value(number);
}

void put_count(ByteWriter& writer, std::size_t count) { writer.value(static_cast<std::uint32_t>(count)); }

double finite(ByteReader& reader, const char* what) {
  const auto number = reader.value<double>();
  if (!std::isfinite(number)) reader.fail(what);
  return number;
}

template <int size>
Eigen::Matrix<double, size, 1> vector(ByteReader& reader, const char* what) {
  Eigen::Matrix<double, size, 1> values;
  for (double& value : values) value = finite(reader, what);
  return values;
}

Eigen::Vector3d unit_vector(ByteReader& reader, const char* what) {
  const Eigen::Vector3d direction = vector<3>(reader, what);
  if (!(std::abs(direction.norm() - 1.0) < 1e-9)) reader.fail(what);
  return direction;
}

void read_range(ByteReader& reader, SensorTable& table) {
  SensorRange& range = table.range;
  for (double* number : {&range.nearest_m, &range.farthest_m, &range.tolerance_px, &table.drift_px}) {
    *number = finite(reader, "the range");
    if (!(*number > 0.0)) reader.fail("the range");
  }
}

void read_rays(ByteReader& reader, RayTable& rays) {
  rays.size = {reader.count(1, kMostPixels, "the image's width"), reader.count(1, kMostPixels, "the image's height")};
  rays.step_px = finite(reader, "the step of the rays");
  if (!(rays.step_px >= 1.0)) reader.fail("the step of the rays");
  rays.columns = nodes_over(rays.size.width, rays.step_px);
  rays.rows = nodes_over(rays.size.height, rays.step_px);
  rays.error_rad = finite(reader, "the error of the rays");
  rays.nodes = reader.values<double>(std::size_t{3} * rays.columns * rays.rows);
}

TableBeam read_beam(ByteReader& reader, const LaserGrid& grid) {
  TableBeam beam;
  beam.row = reader.count(0, grid.rows - 1, "a beam's row");
  beam.column = reader.count(0, grid.columns - 1, "a beam's column");
  beam.measured = reader.count(0, 1, "a beam's origin") == 1;
  beam.line.point = vector<3>(reader, "a beam's point");
  beam.line.direction = unit_vector(reader, "a beam's direction");
  for (double& number : beam.covariance.reshaped()) number = finite(reader, "a beam's covariance");
  beam.per_wavelength = vector<4>(reader, "a beam's drift");
  return beam;
}

void read_candidates(ByteReader& reader, const ImageSize& size, int beams, CandidateLists& lists) {
  lists.cell_px = reader.count(1, kMostPixels, "the cells");
  lists.columns = (size.width + lists.cell_px - 1) / lists.cell_px;
  lists.rows = (size.height + lists.cell_px - 1) / lists.cell_px;
  lists.first = reader.values<std::uint32_t>(static_cast<std::size_t>(lists.columns) * lists.rows + 1);
  if (lists.first.front() != 0) reader.fail("the candidates");
  for (std::size_t cell = 1; cell < lists.first.size(); ++cell) {
    if (lists.first[cell] < lists.first[cell - 1]) reader.fail("the candidates");
  }
  lists.beams = reader.values<std::uint16_t>(lists.first.back());
  for (const std::uint16_t beam : lists.beams) {
    if (beam >= beams) reader.fail("the candidates");
  }
}

SelfTest read_self_test(ByteReader& reader, const ImageSize& size, int beams) {
  SelfTest test;
  test.pixel = vector<2>(reader, "a pixel of the self-test");
  if ((test.pixel.array() < 0.0).any() || test.pixel.x() > size.width - 1 || test.pixel.y() > size.height - 1) {
    reader.fail("a pixel of the self-test");
  }
  test.ray = unit_vector(reader, "a ray of the self-test");
  test.beam = reader.count(0, beams - 1, "a beam of the self-test");
  test.depth_m = finite(reader, "a depth of the self-test");
  return test;
}

}  // namespace

std::string bytes_from_table(const SensorTable& table) {
  ByteWriter writer;
  writer.text("m, rad, px; camera frame: x right, y down, z forward; pixel (0, 0) is the centre of the first pixel");
  writer.text(table.camera);
  writer.text(table.origin);
  for (const double number :
       {table.range.nearest_m, table.range.farthest_m, table.range.tolerance_px, table.drift_px}) {
    writer.value(number);
  }
  put_count(writer, table.rays.size.width);
  put_count(writer, table.rays.size.height);
  writer.value(table.rays.step_px);
  writer.value(table.rays.error_rad);
  writer.values<double>(table.rays.nodes);
  put_count(writer, table.grid.rows);
  put_count(writer, table.grid.columns);
  put(writer, table.shared_covariance);
  put_count(writer, table.beams.size());
  for (const TableBeam& beam : table.beams) {
    put_count(writer, beam.row);
    put_count(writer, beam.column);
    put_count(writer, beam.measured);
    put(writer, beam.line.point);
    put(writer, beam.line.direction);
    put(writer, beam.covariance);
    put(writer, beam.per_wavelength);
  }
  put_count(writer, table.candidates.cell_px);
  writer.values<std::uint32_t>(table.candidates.first);
  writer.values<std::uint16_t>(table.candidates.beams);
  put_count(writer, table.self_tests.size());
  for (const SelfTest& test : table.self_tests) {
    put(writer, test.pixel);
    put(writer, test.ray);
    put_count(writer, test.beam);
    writer.value(test.depth_m);
  }
  return checked_file(kTableKind, writer.bytes());
}

SensorTable table_from_bytes(std::string_view bytes, const std::string& where) {
  ByteReader reader(checked_payload(kTableKind, bytes, where), where, kTableKind.remake);
  SensorTable table;
  table.serial = serial_of(bytes);
  reader.text();  // units: for people
  table.camera = reader.text();
  table.origin = reader.text();
  read_range(reader, table);
  read_rays(reader, table.rays);
  table.grid.rows = reader.count(1, kMostBeams, "the rows of beams");
  table.grid.columns = reader.count(1, kMostBeams / table.grid.rows, "the columns of beams");
  for (double& number : table.shared_covariance.reshaped()) {
    number = finite(reader, "the covariance that the beams share");
  }
  const int beams = reader.count(1, kMostBeams, "the number of beams");
  for (int i = 0; i < beams; ++i) {
    const TableBeam beam = read_beam(reader, table.grid);
    const bool later = table.beams.empty() ||
                       std::pair(table.beams.back().row, table.beams.back().column) < std::pair(beam.row, beam.column);
    if (!later) reader.fail("the order of the beams");
    table.beams.push_back(beam);
  }
  read_candidates(reader, table.rays.size, beams, table.candidates);
  const int tests = reader.count(0, kMostTests, "the self-test");
  for (int i = 0; i < tests; ++i) table.self_tests.push_back(read_self_test(reader, table.rays.size, beams));
  reader.expect_end();
  replay_self_tests(table, where);
  return table;
}

SensorTable read_table(const std::filesystem::path& path) {
  return table_from_bytes(text_of_file(path), path.string());
}

bool is_table(std::string_view bytes) { return bytes.starts_with(std::string_view(kTableKind.magic, 8)); }

}  // namespace raybundle
