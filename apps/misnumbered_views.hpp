// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "detect_images.hpp"

namespace raybundle::apps {

/// Leaves out views of flat boards whose corners do not lie in the image as on the board, and names each among the
/// unused images: corners in another order (rows and columns exchanged, or another board), and corners in mirror order
/// compared with most views of the same camera. A solve would not notice the latter: such a view fits as a board seen
/// from behind.
///
/// @throws Error(kBadInput) when most views of a camera are in another order
void leave_out_misnumbered_views(DetectedImages& images);

}  // namespace raybundle::apps
