// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/occupancy/case_base_file.hpp"

#include <span>

#include "raybundle/device/byte_stream.hpp"
#include "raybundle/device/checked_file.hpp"

namespace raybundle {
namespace {

constexpr FileKind kKind{"RBOCCUPY", 1, "base of occupancy cases", "raybundle occupancy learn"};
constexpr int kMostCases = 1 << 20;

void add_matrix(ByteWriter& writer, const Eigen::MatrixXd& matrix) {
  writer.values(std::span<const double>(matrix.data(), static_cast<std::size_t>(matrix.size())));
}

Eigen::MatrixXd next_matrix(ByteReader& reader, int rows, int columns) {
  const std::vector<double> values = reader.values<double>(static_cast<std::size_t>(rows) * columns);
  return Eigen::Map<const Eigen::MatrixXd>(values.data(), rows, columns);
}

}  // namespace

std::string bytes_from_case_base(const CaseBase& base) {
  base.check();
  ByteWriter writer;
  const auto add_count = [&](Eigen::Index count) { writer.value(static_cast<std::uint32_t>(count)); };
  writer.text(base.attribute_set);
  add_count(static_cast<Eigen::Index>(base.group_names.size()));
  for (const std::string& name : base.group_names) writer.text(name);
  add_count(static_cast<Eigen::Index>(base.situations.size()));
  for (const SituationClass& situation : base.situations) {
    writer.text(situation.name);
    add_count(situation.group);
    add_count(situation.inert ? 1 : 0);
  }
  add_count(base.neighbours);
  writer.value(base.farthest);
  add_count(base.metric_from_attributes.rows());
  add_count(base.metric_from_attributes.cols());
  add_count(base.cases.cols());
  add_matrix(writer, base.metric_from_attributes);
  add_matrix(writer, base.cases);
  writer.values(std::span<const std::uint8_t>(base.classes));
  for (const AirbagAction action : base.actions) writer.value(static_cast<std::uint8_t>(action));
  return checked_file(kKind, writer.bytes());
}

CaseBase case_base_from_bytes(std::string_view bytes, const std::string& where) {
  ByteReader reader(checked_payload(kKind, bytes, where), where);
  CaseBase base;
  base.attribute_set = reader.text();
  base.group_names.resize(static_cast<std::size_t>(reader.count(1, kMostClasses, "the number of groups")));
  for (std::string& name : base.group_names) name = reader.text();
  base.situations.resize(static_cast<std::size_t>(reader.count(1, kMostClasses, "the number of classes")));
  for (SituationClass& situation : base.situations) {
    situation.name = reader.text();
    situation.group = reader.count(0, kMostClasses, "a group");
    situation.inert = reader.count(0, 1, "whether a class is inert") == 1;
  }
  base.neighbours = reader.count(1, kMostNeighbours, "the number of neighbours");
  base.farthest = reader.value<double>();
  const int size = reader.count(1, kMostMetricSize, "the size of the metric");
  const int attributes = reader.count(1, 4096, "the number of attributes");
  const int cases = reader.count(1, kMostCases, "the number of cases");
  base.metric_from_attributes = next_matrix(reader, size, attributes);
  base.cases = next_matrix(reader, size, cases);
  base.classes = reader.values<std::uint8_t>(static_cast<std::size_t>(cases));
  for (const std::uint8_t action : reader.values<std::uint8_t>(static_cast<std::size_t>(cases))) {
    base.actions.push_back(static_cast<AirbagAction>(action));
  }
  reader.expect_end();
  base.check();
  return base;
}

}  // namespace raybundle
