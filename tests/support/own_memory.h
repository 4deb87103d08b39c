#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace rubicon::support {

/// The last characters of a secret, each changed: a test keeps these, and does not put the secret itself into memory.
/// The first ones are overwritten by whoever frees it.
std::string masked_end(std::string_view secret);
/// How often the heap of this process has them, in what is freed too.
std::size_t count_in_heap(std::string_view masked);

}  // namespace rubicon::support
