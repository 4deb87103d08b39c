#include "networks/knx/tunnel_round.h"

#include <fmt/format.h>

namespace rubicon::networks::knx {

std::vector<wire::IndividualAddress> TunnelRound::unusable() const {
  auto all = taken_;
  all.insert(all.end(), users_refused_.begin(), users_refused_.end());
  return all;
}

bool TunnelRound::end(bool last_was_refused, const std::string& why) {
  const bool others_wait = last_was_refused && !taken_.empty();
  text_ = why;
  for (const auto tunnel : users_refused_)
    text_ += fmt::format("{}the interface refuses the user of {}", text_.empty() ? "" : "; ", to_string(tunnel));
  if (last_was_refused && taken_.empty()) users_refused_.clear();
  taken_.clear();
  return others_wait;
}

void TunnelRound::up() {
  taken_.clear();
  text_.clear();
}

}  // namespace rubicon::networks::knx
