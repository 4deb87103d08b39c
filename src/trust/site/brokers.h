#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "trust/site/mosquitto_setup.h"
#include "trust/site/site_folder.h"

namespace rubicon::trust::site {

/// A folder with the files of a mosquitto, which this realm writes.
struct BrokerFolder {
  MosquittoSetup setup;
  std::string unit;  ///< `rubicon-broker@main`; empty = no unit runs it

  friend bool operator==(const BrokerFolder&, const BrokerFolder&) = default;
};

/// The brokers of a realm, as its authority knows them (`ca/brokers`).
struct BrokerList {
  std::vector<std::string> hosts;  ///< HOST or HOST:PORT, as members reach them; the first one is preferred
  std::vector<BrokerFolder> folders;

  static Result<BrokerList> read(const SiteFolder& folder);
  Result<void> write(const SiteFolder& folder) const;

  BrokerFolder* find(const std::string& folder);
  bool take_passwords() const;
  /// HOST:PORT of each host: where a member with a certificate, or one with a password, connects to.
  std::vector<std::string> addresses(bool with_password) const;
  /// The hosts without ports, for certificates.
  std::vector<std::string> names() const;
};

/// kInvalid: is no HOST or HOST:PORT.
Result<void> check_broker(const std::string& text);

}  // namespace rubicon::trust::site
