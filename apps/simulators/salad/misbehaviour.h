#pragma once

#include <random>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "rubicon/result.hpp"

namespace rubicon::salad_simulator {

/// What a bad network, or a bad SALAD, does to a proxy.
enum class Misbehaviour : std::uint8_t {
  kGarbage,     ///< a datagram of each row of the bad-input table (salad.md, section 4), one after the other
  kLoss,        ///< one publication of five is not sent
  kDuplicates,  ///< one of five is sent twice
  kBursts,      ///< one of ten is sent fifty times
  kSilence,     ///< one of fifty is followed by five seconds of nothing
};

/// `garbage`, ..., or `all`; kInvalid names the words there are.
Result<std::set<Misbehaviour>> parse_misbehaviours(const std::vector<std::string>& words);

/// One datagram and more for each row of the bad-input table; `unknown` is an id that is not configured.
std::vector<std::string> bad_datagrams(unsigned unknown);

}  // namespace rubicon::salad_simulator
