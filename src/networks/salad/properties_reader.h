#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "rubicon/result.hpp"

namespace rubicon::networks::salad {

/// One logical line of a properties file, escapes resolved, in UTF-8.
struct Property {
  int line = 0;  ///< where it begins, counted from 1
  std::string key, value;
  std::string fault;  ///< not empty: the error in the line; key and value are then invalid
};

/// Reads a file by the rules of java.util.Properties.load (the Java API documentation): ISO 8859-1; `#` and `!` begin
/// comment lines; `=`, `:` or blanks end the key; a backslash at the end continues a line; \t \n \r \f \uXXXX. Keys may
/// appear twice.
std::vector<Property> read_properties(std::string_view text);

}  // namespace rubicon::networks::salad
