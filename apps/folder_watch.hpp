// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>

namespace raybundle::apps {

/// Calls take(path) for each image that is or comes into a folder, by name, once each, until take() returns false or
/// somebody interrupts the program (SIGINT or SIGTERM). A file counts as there when it has stayed the same for a
/// moment. An Error about the file itself is a warning; of kind kIo, the file may not be whole yet and is tried again
/// while it changes, and some seconds longer. Other errors are thrown on.
///
/// @throws Error(kIo) when there is no such folder, or no longer
void watch_folder(const std::string& folder, const std::function<bool(const std::string& path)>& take);

}  // namespace raybundle::apps
