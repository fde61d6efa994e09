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
/// Of a camera most of whose views of a board are in another order none of them is kept, with a warning.
///
/// @throws Error(kBadInput) when that is so of every camera
void leave_out_misnumbered_views(DetectedImages& images);

}  // namespace raybundle::apps
