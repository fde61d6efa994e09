// SPDX-FileCopyrightText: The Raybundle authors
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <tuple>
#include <utility>

namespace raybundle {

/// A list of types to loop over; the generated list of camera models is one.
template <typename... Types>
struct TypeList {
  static constexpr std::size_t kSize = sizeof...(Types);

  template <std::size_t index>
  using At = std::tuple_element_t<index, std::tuple<Types...>>;

  /// Calls function.operator()<Type>() for each type, in order.
  template <typename Function>
  static void for_each(Function&& function) {
    (function.template operator()<Types>(), ...);
  }
};

}  // namespace raybundle
