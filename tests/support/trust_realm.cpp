#include "support/trust_realm.h"

#include <chrono>
#include <stdexcept>

namespace rubicon::support {

namespace {

template <class T>
T value_of(Result<T> result) {
  if (!result) throw std::runtime_error(result.error().text);
  return std::move(*result);
}

}  // namespace

WallTime wall_clock() {
  return std::chrono::time_point_cast<WallTime::duration>(std::chrono::system_clock::now());
}

TrustRealm::TrustRealm(std::filesystem::path folder, const std::vector<OwnerId>& islands) : folder_(std::move(folder)) {
  value_of(trust::init(folder_, {"Test", islands}, wall_clock()));
}

tuples::Member TrustRealm::add(const std::string& name, const std::vector<std::string>& roles, OwnerId island) {
  return value_of(trust::add_here(folder_, {name, island, roles, trust::kMemberDays}, wall_clock()));
}

std::string TrustRealm::revoke(const std::string& name) {
  return value_of(trust::revoke(folder_, name, wall_clock()));
}

void TrustRealm::renew(const std::string& name) {
  value_of(trust::renew(folder_, name, trust::kMemberDays, wall_clock()));
}

std::shared_ptr<trust::Trust> TrustRealm::open(const std::string& member, base::Scheduler& scheduler,
                                               base::LogSink& sink) const {
  return value_of(trust::Trust::open(place(member), scheduler, Log(sink, "trust")));
}

}  // namespace rubicon::support
