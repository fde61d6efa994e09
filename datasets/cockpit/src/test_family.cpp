// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#include "family.hpp"
#include "raybundle/geometry/error.hpp"

namespace raybundle {

const CabinFamily& test_family() { throw Error(ErrorKind::kBadInput, "there is no test generator yet"); }

}  // namespace raybundle
