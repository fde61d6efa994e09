// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "detect_images.hpp"

namespace raybundle::apps {

/// Leaves out views that repeat an earlier one of the same camera to the last bit, as a copied image or a frozen camera
/// gives, and names each among the unused images: counted twice, they would make the sigmas too small.
void leave_out_repeated_views(DetectedImages& images);

}  // namespace raybundle::apps
