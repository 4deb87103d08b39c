#pragma once

#include <memory>
#include <string_view>

#include "base/log.h"
#include "config/mqtt_space_config.h"
#include "trust/site/known_realm.h"
#include "tuples/member.h"

namespace rubicon::daemon {

/// What the daemon knows of the realm whose members meet at its broker: the file beside the certificate of the
/// authority.
class SitePart {
 public:
  explicit SitePart(base::Log log) : log_(std::move(log)) {}

  /// Reads the realm file; there is none if the configuration names no authority, or has another one. The errors of
  /// KnownRealm::open().
  Result<void> open(const config::MqttSpaceSetup& setup, WallTime now);
  bool has_realm() const { return realm_ != nullptr; }
  /// nullptr: no member, or shut out.
  std::shared_ptr<const tuples::Member> member(std::string_view user) const;
  /// The folder may have a newer file. True: it had.
  bool look();

 private:
  base::Log log_;
  std::unique_ptr<trust::site::KnownRealm> realm_;
};

}  // namespace rubicon::daemon
