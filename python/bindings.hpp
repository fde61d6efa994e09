// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/eigen.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <string>

#include "raybundle/camera/camera.hpp"
#include "raybundle/geometry/rigid3_matrix.hpp"

namespace raybundle::python {

/// Points or pixels, one in each row.
template <int size>
using Rows = Eigen::Matrix<double, Eigen::Dynamic, size, Eigen::RowMajor>;

/// @throws Error(kBadInput) when the upper left part is no rotation
Rigid3 rigid3_of(const Eigen::Matrix4d& b_from_a);

/// The camera model of that name.
///
/// @throws Error(kBadInput) naming those that there are
ModelId model_of(const std::string& name);

// One in each file; module.cpp calls them in this order, because docstrings name types that are known by then.
void bind_camera(pybind11::module_& module);
void bind_calibration(pybind11::module_& module);
void bind_problem(pybind11::module_& module);
void bind_calibrate(pybind11::module_& module);

}  // namespace raybundle::python
