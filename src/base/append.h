#pragma once

#include <fmt/core.h>

#include <string>
#include <utility>

namespace rubicon::base {

void append_arguments(std::string& out, fmt::string_view format, fmt::format_args arguments);

/// Appends the formatted text. fmt::format_to would compile fmt's formatting of numbers once more in each block.
template <class... Arguments>
void append(std::string& out, fmt::format_string<Arguments...> format, Arguments&&... arguments) {
  append_arguments(out, format, fmt::make_format_args(arguments...));
}

}  // namespace rubicon::base
