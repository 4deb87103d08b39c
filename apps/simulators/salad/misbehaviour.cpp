#include "apps/simulators/salad/misbehaviour.h"

#include <fmt/format.h>

#include <array>
#include <utility>

#include "rubicon/key.hpp"

namespace rubicon::salad_simulator {

namespace {

constexpr std::array<std::pair<std::string_view, Misbehaviour>, 5> kNames{{{"garbage", Misbehaviour::kGarbage},
                                                                           {"loss", Misbehaviour::kLoss},
                                                                           {"duplicates", Misbehaviour::kDuplicates},
                                                                           {"bursts", Misbehaviour::kBursts},
                                                                           {"silence", Misbehaviour::kSilence}}};

}  // namespace

Result<std::set<Misbehaviour>> parse_misbehaviours(const std::vector<std::string>& words) {
  std::set<Misbehaviour> found;
  for (const auto& word : words) {
    bool known = word == "all";
    for (const auto& [name, kind] : kNames) {
      if (word != name && word != "all") continue;
      found.insert(kind);
      known = true;
    }
    if (!known)
      return fail(ErrorCode::kInvalid,
                  fmt::format("{}: expected garbage, loss, duplicates, bursts, silence or all", model::quoted(word)));
  }
  return found;
}

std::vector<std::string> bad_datagrams(unsigned unknown) {
  std::vector<std::string> all{"garbage", "", std::string("\0\x01\xff\xfe#SALADST#", 13), "#SALADST#", "#SALADST##"};
  for (const auto* value : {"abc", "", "1,5", "NaN", "Infinity", "-Infinity", "1e400", "0x1", "1f", "1d"})
    all.push_back(fmt::format("#SALADST#1;{}#END#", value));
  for (const auto* id : {"x", "", "-1", "0", "65536", "99999999999999999999", "1.5"})
    all.push_back(fmt::format("#SALADST#{};1#END#", id));
  all.push_back(fmt::format("#SALADST#{};7#END#", unknown));
  all.insert(all.end(), {"#SALADST#1#END#", "#SALADST#1;1;1#END#", "#SALADST#;#END#", "#SALADST#:::#END#"});
  all.push_back("#SALADST#1;" + std::string(60000, '9'));
  return all;
}

}  // namespace rubicon::salad_simulator
