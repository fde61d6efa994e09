// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

namespace raybundle::apps {

/// Points in space with what is known of each, and triangles between them.
struct PointMesh {
  std::vector<Eigen::Vector3d> points;        ///< [m], x right, y down, z forward
  std::vector<std::array<int, 3>> triangles;  ///< counter-clockwise from outside
  std::vector<std::string> names;             ///< of further numbers of each point, may be empty
  std::vector<std::vector<double>> numbers;   ///< aligned with names; each as long as points
};

/// PLY 1.0, ASCII; the further numbers are properties of its vertices.
std::string ply_from(const PointMesh& mesh);

/// glTF 2.0, binary. Viewers look along -z with y up, which the node's rotation sees to. Without triangles it holds
/// points.
std::string glb_from(const PointMesh& mesh);

}  // namespace raybundle::apps
