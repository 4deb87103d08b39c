#pragma once

#include <string>
#include <string_view>

#include "rubicon/result.hpp"

namespace rubicon::island {

// Changes of the text of a configuration file. Text is inserted where the parser found the keys, the tree is never
// written: comments, order and style of the rest stay byte for byte. Each result is parsed again and must be the old
// tree with that one change. kUnsupported: the file is written in a style for which that does not hold. `file` is its
// name, for errors.

/// Adds a network at the end of `networks:`, which is made where there is none. `options`: a map in YAML, in lines or
/// in braces. kDuplicate: there is one of that name; kInvalid: the name or the options are wrong.
Result<std::string> with_network(std::string_view text, const std::string& file, const std::string& network,
                                 std::string_view options);

/// Sets an option of a network, which has another value or none. kNotFound: there is no such network.
Result<std::string> with_option(std::string_view text, const std::string& file, const std::string& network,
                                const std::string& option, const std::string& value);

/// The network as with_network() inserts it, below `networks:`, for people who insert it themselves.
std::string network_text(const std::string& network, std::string_view options);

/// A scalar that YAML reads as this text: bare where that is possible, else in quotes.
std::string scalar_text(std::string_view text);

}  // namespace rubicon::island
