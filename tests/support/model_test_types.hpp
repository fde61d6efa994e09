// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <gtest/gtest.h>

#include "raybundle/camera/model_list.hpp"

namespace raybundle {

/// The one list of models as GoogleTest wants it.
template <typename List>
struct AsTestTypes;
template <typename... M>
struct AsTestTypes<TypeList<M...>> {
  using Type = ::testing::Types<M...>;
};

}  // namespace raybundle
