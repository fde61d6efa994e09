// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "mesh_files.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <iterator>
#include <nlohmann/json.hpp>

namespace raybundle::apps {
namespace {

template <typename Value>
void append(std::string& bytes, Value value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

// A chunk of a binary glTF: length, kind, bytes filled up to a multiple of four.
void append_chunk(std::string& file, const char (&kind)[5], std::string bytes, char fill) {
  bytes.resize((bytes.size() + 3) / 4 * 4, fill);
  append(file, static_cast<std::uint32_t>(bytes.size()));
  file.append(kind, 4).append(bytes);
}

// What a glTF says of points and triangles that lie in this order in its binary chunk.
nlohmann::ordered_json gltf_of(const PointMesh& mesh, std::size_t bytes) {
  using Json = nlohmann::ordered_json;
  constexpr int kFloat = 5126, kUnsigned = 5125, kPoints = 0, kTriangles = 4;
  Eigen::Vector3f low = mesh.points.front().cast<float>(), high = low;
  for (const Eigen::Vector3d& point : mesh.points) {
    low = low.cwiseMin(point.cast<float>());
    high = high.cwiseMax(point.cast<float>());
  }
  const std::size_t of_points = 3 * sizeof(float) * mesh.points.size();
  Json gltf{{"asset", {{"version", "2.0"}, {"generator", "raybundle"}}}, {"scene", 0}};
  gltf["scenes"] = Json::array({{{"nodes", Json::array({0})}}});
  gltf["nodes"] = Json::array({{{"mesh", 0}, {"rotation", {1, 0, 0, 0}}}});  // half a turn about x
  gltf["materials"] = Json::array({{{"doubleSided", true}, {"pbrMetallicRoughness", {{"metallicFactor", 0.0}}}}});
  gltf["buffers"] = Json::array({{{"byteLength", bytes}}});
  gltf["bufferViews"] = Json::array({{{"buffer", 0}, {"byteOffset", 0}, {"byteLength", of_points}}});
  gltf["accessors"] = Json::array({{{"bufferView", 0},
                                    {"componentType", kFloat},
                                    {"count", mesh.points.size()},
                                    {"type", "VEC3"},
                                    {"min", {low.x(), low.y(), low.z()}},
                                    {"max", {high.x(), high.y(), high.z()}}}});
  Json primitive{{"attributes", {{"POSITION", 0}}}, {"material", 0}, {"mode", kPoints}};
  if (!mesh.triangles.empty()) {
    primitive["mode"] = kTriangles;
    primitive["indices"] = 1;
    gltf["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", of_points}, {"byteLength", bytes - of_points}});
    gltf["accessors"].push_back(
        {{"bufferView", 1}, {"componentType", kUnsigned}, {"count", 3 * mesh.triangles.size()}, {"type", "SCALAR"}});
  }
  gltf["meshes"] = Json::array({{{"primitives", Json::array({primitive})}}});
  return gltf;
}

}  // namespace

std::string ply_from(const PointMesh& mesh) {
  std::string text = fmt::format(
      "ply\nformat ascii 1.0\ncomment metres; x right, y down, z forward\nelement vertex {}\nproperty double x\n"
      "property double y\nproperty double z\n",
      mesh.points.size());
  auto out = std::back_inserter(text);
  for (const std::string& name : mesh.names) fmt::format_to(out, "property double {}\n", name);
  fmt::format_to(out, "element face {}\nproperty list uchar int vertex_indices\nend_header\n", mesh.triangles.size());
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    fmt::format_to(out, "{} {} {}", mesh.points[i].x(), mesh.points[i].y(), mesh.points[i].z());
    for (const auto& numbers : mesh.numbers) fmt::format_to(out, " {}", numbers[i]);
    text += '\n';
  }
  for (const auto& [a, b, c] : mesh.triangles) fmt::format_to(out, "3 {} {} {}\n", a, b, c);
  return text;
}

std::string glb_from(const PointMesh& mesh) {
  std::string binary, chunks;
  for (const Eigen::Vector3d& point : mesh.points) {
    for (const double number : point) append(binary, static_cast<float>(number));
  }
  for (const auto& triangle : mesh.triangles) {
    for (const int index : triangle) append(binary, static_cast<std::uint32_t>(index));
  }
  const bool empty = mesh.points.empty();
  const nlohmann::ordered_json nothing{{"asset", {{"version", "2.0"}, {"generator", "raybundle"}}}};
  append_chunk(chunks, "JSON", (empty ? nothing : gltf_of(mesh, binary.size())).dump(), ' ');
  if (!empty) append_chunk(chunks, "BIN\0", binary, '\0');
  std::string file = "glTF";
  append(file, std::uint32_t{2});
  append(file, static_cast<std::uint32_t>(12 + chunks.size()));
  return file + chunks;
}

}  // namespace raybundle::apps
