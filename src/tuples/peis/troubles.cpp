#include "tuples/peis/troubles.h"

#include <algorithm>
#include <utility>

namespace rubicon::tuples::peis {

namespace {

constexpr std::size_t kMaxText = 256;

}  // namespace

void Troubles::note(TroubleKind kind, OwnerId id, std::string_view name, std::string_view detail) {
  name = name.substr(0, kMaxText);
  const auto known = std::find_if(all_.begin(), all_.end(), [&](const Trouble& one) {
    return one.kind == kind && one.id == id && one.name == name;
  });
  Trouble news{kind, id, std::string(name), std::string(detail.substr(0, kMaxText)), 1};
  if (known != all_.end()) {
    news.times += known->times;
    all_.erase(known);
  } else if (all_.size() >= kMax) {
    all_.erase(all_.begin());
  }
  all_.push_back(std::move(news));
}

void Troubles::reached(OwnerId id, std::string_view address) {
  all_.erase(std::remove_if(all_.begin(), all_.end(),
                            [&](const Trouble& one) {
                              const bool is_it = one.id != OwnerId{} ? one.id == id : one.name == address;
                              return one.kind == TroubleKind::kUnreachable && is_it;
                            }),
             all_.end());
}

}  // namespace rubicon::tuples::peis
