// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "raybundle/io/foreign_format.hpp"

namespace raybundle {

// One in each file of this folder; foreign_format.cpp has the list.
ForeignFormat basalt_format();
ForeignFormat camodocal_format();
ForeignFormat colmap_format();
ForeignFormat kalibr_format();
ForeignFormat mrcal_format();
ForeignFormat opencv_format();
ForeignFormat ros_format();

}  // namespace raybundle
