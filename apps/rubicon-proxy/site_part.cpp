#include "apps/rubicon-proxy/site_part.h"

#include <fmt/format.h>

#include "trust/site/realm_members.h"

namespace rubicon::daemon {

Result<void> SitePart::open(const config::MqttSpaceSetup& setup, WallTime now) {
  const auto folder = setup.realm_folder();
  if (folder.empty()) return {};
  trust::site::SitePlace place;
  place.folder = folder;
  auto known = trust::site::KnownRealm::open(place, now);
  if (!known) return fail(std::move(known.error()));
  realm_ = std::make_unique<trust::site::KnownRealm>(std::move(*known));
  log_.info(fmt::format("realm {}: {} members", realm_->realm().name, realm_->realm().members.size()));
  return {};
}

std::shared_ptr<const tuples::Member> SitePart::member(std::string_view user) const {
  return realm_ ? trust::site::member_of(realm_->realm(), user) : nullptr;
}

bool SitePart::look() {
  return realm_ && realm_->look();
}

}  // namespace rubicon::daemon
