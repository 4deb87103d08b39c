#pragma once

#include <string>
#include <string_view>

#include "rubicon/result.hpp"
#include "trust/realm.h"

namespace rubicon::trust {

inline constexpr std::size_t kLargestBundle = 2U << 20U;  ///< bytes

/// What a member takes to its host in one file.
struct Bundle {
  Papers papers;
  std::string key;  ///< PrivateKey::encrypted(); empty = the key is on that host already
};

/// JSON, with one line for each paper.
std::string bundle_text(const Bundle& bundle);
/// Reads the form only: check_papers() checks the content. kInvalid: not a bundle, or with a key that no pass phrase
/// protects.
Result<Bundle> read_bundle(std::string_view text);

}  // namespace rubicon::trust
