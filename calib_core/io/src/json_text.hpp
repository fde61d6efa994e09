// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "raybundle/geometry/rigid3.hpp"
#include "raybundle/io/provenance.hpp"
#include "raybundle/scene/target.hpp"

namespace raybundle {

/// Keys are written in the order in which they were set.
using OrderedJson = nlohmann::ordered_json;

/// An array too long to be held as JSON: its entries are made one by one.
struct LongArray {
  std::string key;  ///< at the top of the value, which holds an empty array there
  std::size_t size = 0;
  std::function<OrderedJson(std::size_t)> entry;
};

/// JSON for people and programs: objects are indented, arrays of plain values, and objects of plain values in an array,
/// stay on one line. Numbers have the shortest digits that bring back the same bits; what is not finite becomes null; no "<".
///
/// @param lines  keys of arrays whose entries are written one a line, whatever they hold
/// @param long_array  one more of them
std::string pretty_text(const OrderedJson& value, const std::vector<std::string>& lines = {},
                        const LongArray* long_array = nullptr);

OrderedJson json_from_vector(const Eigen::Ref<const Eigen::VectorXd>& values);
OrderedJson json_from_rigid3(const Rigid3& b_from_a);
OrderedJson json_from_points(const Target& target);      ///< [[id, x, y, z], ...]
OrderedJson json_from_symmetries(const Target& target);  ///< [[id, ...], ...]
OrderedJson json_from_shape(const BoardShape& shape);
OrderedJson json_from_provenance(const Provenance& provenance);

}  // namespace raybundle
