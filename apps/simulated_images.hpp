// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "raybundle/synthetic/render.hpp"
#include "raybundle/synthetic/simulate.hpp"
#include "simulated_board.hpp"

namespace raybundle::apps {

/// `images/left/007_off.png`: the image of a camera, relative to the data set; of the laser when it is on.
///
/// @param frame  its number, or * for all
std::string simulated_image(const std::string& camera, const std::string& frame, bool laser);

/// The same for a frame's number, with leading zeros.
std::string simulated_image(const std::string& camera, int frame, bool laser);

/// 10 and 12 bits are stretched to the 16 of a PNG.
void write_png(const std::filesystem::path& path, const GreyImage& image);

/// @throws Error(kBadInput) when the board has no print, or a camera a name that is none for a folder
void require_images(const BoardedRig& boarded);

/// Removes the images of these cameras that a former run left, and says so: they would be taken for those of this one.
///
/// @param folder  of the data set
/// @throws Error(kIo)
void remove_former_images(const std::filesystem::path& folder, const std::vector<SimulatedCamera>& cameras);

/// Renders and writes the images of all cameras and frames, whether they show the board or not. The number of threads
/// does not change a bit.
///
/// @param boarded  as require_images() lets it pass
/// @throws Error(kIo)
void write_images(const std::filesystem::path& folder, const BoardedRig& boarded, const Simulation& simulation,
                  const SimulateOptions& options, int threads);

}  // namespace raybundle::apps
