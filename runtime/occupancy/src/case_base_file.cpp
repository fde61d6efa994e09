// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "raybundle/occupancy/case_base_file.hpp"

#include <span>

#include "raybundle/device/byte_stream.hpp"

namespace raybundle {
namespace {

constexpr int kMostCases = 1 << 20;

void add_matrix(ByteWriter& writer, const Eigen::Ref<const Eigen::MatrixXf>& matrix) {
  writer.values(std::span<const float>(matrix.data(), static_cast<std::size_t>(matrix.size())));
}

Eigen::MatrixXf next_matrix(ByteReader& reader, int rows, int columns) {
  const std::vector<float> values = reader.values<float>(static_cast<std::size_t>(rows) * columns);
  return Eigen::Map<const Eigen::MatrixXf>(values.data(), rows, columns);
}

Embedding next_embedding(ByteReader& reader) {
  Embedding embedding;
  int size = reader.count(1, kMostUnits, "the number of attributes");
  embedding.centre = next_matrix(reader, size, 1);
  embedding.scale = next_matrix(reader, size, 1);
  embedding.layers.resize(static_cast<std::size_t>(reader.count(1, kMostLayers, "the number of layers")));
  for (EmbeddingLayer& layer : embedding.layers) {
    const int out = reader.count(1, kMostUnits, "the size of a layer");
    layer.weights = next_matrix(reader, out, size);
    layer.offsets = next_matrix(reader, out, 1);
    size = out;
  }
  return embedding;
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
  writer.value(base.sure_of_group);
  writer.value(base.sure_of_situation);
  add_count(static_cast<Eigen::Index>(base.classes.size()));
  add_count(static_cast<Eigen::Index>(base.spaces.size()));
  for (const CaseSpace& space : base.spaces) {
    add_count(space.embedding.attributes());
    add_matrix(writer, space.embedding.centre);
    add_matrix(writer, space.embedding.scale);
    add_count(static_cast<Eigen::Index>(space.embedding.layers.size()));
    for (const EmbeddingLayer& layer : space.embedding.layers) {
      add_count(layer.weights.rows());
      add_matrix(writer, layer.weights);
      add_matrix(writer, layer.offsets);
    }
    add_matrix(writer, space.cases);
    writer.value(space.farthest);
  }
  writer.values(std::span<const std::uint8_t>(base.classes));
  for (const AirbagAction action : base.actions) writer.value(static_cast<std::uint8_t>(action));
  return checked_file(kCaseBaseKind, writer.bytes());
}

CaseBase case_base_from_bytes(std::string_view bytes, const std::string& where) {
  ByteReader reader(checked_payload(kCaseBaseKind, bytes, where), where, kCaseBaseKind.remake);
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
  base.sure_of_group = reader.value<double>();
  base.sure_of_situation = reader.value<double>();
  const int cases = reader.count(1, kMostCases, "the number of cases");
  base.spaces.resize(static_cast<std::size_t>(reader.count(1, kMostSpaces, "the number of spaces")));
  for (CaseSpace& space : base.spaces) {
    space.embedding = next_embedding(reader);
    space.cases = next_matrix(reader, static_cast<int>(space.embedding.size()), cases);
    space.farthest = reader.value<double>();
  }
  base.classes = reader.values<std::uint8_t>(static_cast<std::size_t>(cases));
  for (const std::uint8_t action : reader.values<std::uint8_t>(static_cast<std::size_t>(cases))) {
    base.actions.push_back(static_cast<AirbagAction>(action));
  }
  reader.expect_end();
  base.check(where);
  return base;
}

}  // namespace raybundle
