// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "bindings.hpp"
#include "raybundle/geometry/error.hpp"

namespace raybundle::python {

Rigid3 rigid3_of(const Eigen::Matrix4d& b_from_a) {
  constexpr double kRounding = 1e-6;
  const auto transform = rigid3_from_matrix(b_from_a.topLeftCorner<3, 3>(), b_from_a.topRightCorner<3, 1>(), kRounding);
  if (!transform) throw Error(ErrorKind::kBadInput, "the upper left 3x3 of a transform has to be a rotation");
  if (!b_from_a.allFinite()) throw Error(ErrorKind::kBadInput, "a transform has to be of finite numbers");
  const Eigen::RowVector4d last = b_from_a.row(3) - Eigen::RowVector4d::Unit(3);
  if (!(last.cwiseAbs().maxCoeff() <= kRounding)) {
    throw Error(ErrorKind::kBadInput,
                "the last row of a transform has to be 0 0 0 1: it multiplies columns, and its last column is the "
                "translation");
  }
  return *transform;
}

}  // namespace raybundle::python

PYBIND11_MODULE(raybundle, module) {
  using namespace raybundle;
  module.doc() =
      "Raybundle: fisheye intrinsics, extrinsics and laser beams in one bundle adjustment, with covariance.\n\n"
      "Lengths are metres, angles radians, images pixels; (0, 0) is the centre of the top-left pixel. Transforms are 4x4 "
      "and called b_from_a. Points and pixels stand in the rows of arrays.";
  module.attr("__version__") = RAYBUNDLE_VERSION;
  pybind11::register_exception<Error>(module, "Error", PyExc_ValueError).doc() =
      "Bad input, files and data that cannot determine the answer: one sentence that says what to do.";
  python::bind_camera(module);
  python::bind_calibration(module);
  python::bind_problem(module);
  python::bind_calibrate(module);
}
