// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/App.hpp>
#include <functional>
#include <string>

namespace raybundle::apps {

/// What every export is told.
struct ExportRequest {
  std::string calibration;
  std::string camera;  ///< may be empty
  std::string output;
  bool json = false;
};

/// Does an export when the flags that ask for it were given; false when they were not.
using Export = std::function<bool(const ExportRequest&)>;

/// Each declares its own flags.
Export add_table_export(CLI::App& verb);
Export add_rectification_export(CLI::App& verb);
Export add_foreign_export(CLI::App& verb);

/// The one list of what `export` can write.
inline constexpr Export (*kExports[])(CLI::App&) = {add_foreign_export, add_table_export, add_rectification_export};

}  // namespace raybundle::apps
