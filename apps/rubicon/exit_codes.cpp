#include "apps/rubicon/exit_codes.h"

#include <array>
#include <utility>

namespace rubicon::cli {

int exit_code_of(std::string_view state) {
  constexpr std::array<std::pair<std::string_view, int>, 10> kCodes{{{"confirmed", kGood},
                                                                     {"assumed", kGood},
                                                                     {"applied", kGood},
                                                                     {"refused", kRefused},
                                                                     {"failed", kNotDone},
                                                                     {"timed-out", kTimedOut},
                                                                     {"expired", kExpired},
                                                                     {"superseded", kSuperseded},
                                                                     {"no-such-owner", kNotThere},
                                                                     {"no-such-tuple", kNotThere}}};
  for (const auto& [word, code] : kCodes) {
    if (word == state) return code;
  }
  return kFailed;
}

}  // namespace rubicon::cli
