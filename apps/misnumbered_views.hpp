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

/// Warns of cameras that see a printed board from behind in most of their views, by a table of corners: their pixels are
/// mirrored, or only the board's points are numbered the other way round.
void warn_of_mirrored_views(const Board& board, const CalibrationProblem& problem);

}  // namespace raybundle::apps
