// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "family.hpp"
#include "raybundle/cockpit/cabin_scene.hpp"

namespace raybundle {

/// A blanket that has fallen from above onto whatever is there, with a tension that bridges narrow gaps.
///
/// @param centre  of the blanket; only x and y count
CabinMesh draped_blanket(const CabinScene& scene, const Eigen::Vector3d& centre, const CabinMaterial& material,
                         Random& random);

}  // namespace raybundle
