#include "trust/site/site_bundle.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <nlohmann/json.hpp>

#include "base/host_port.h"
#include "base/json_depth.h"
#include "model/json_members.h"
#include "model/json_text.h"

namespace rubicon::trust::site {

namespace {

constexpr int kSiteForm = 2, kDdsForm = 1;
constexpr const char* kSiteFormName = "rubicon-trust";
constexpr std::string_view kProtectedKey = "-----BEGIN ENCRYPTED PRIVATE KEY-----\n";
constexpr std::size_t kMostBrokers = 16;
constexpr std::uint16_t kTlsPort = 8883;

/// The parts by their names in the file, the brokers besides.
constexpr std::array<std::pair<const char*, std::string SiteBundle::*>, 6> kParts{
    {{"authority", &SiteBundle::authority},
     {"realm", &SiteBundle::realm},
     {"certificate", &SiteBundle::certificate},
     {"key", &SiteBundle::key},
     {"user", &SiteBundle::user},
     {"password", &SiteBundle::password_hash}}};
constexpr const char* kBrokers = "brokers";

tl::unexpected<Error> no_site_bundle(std::string_view why) {
  return fail(ErrorCode::kInvalid, fmt::format("the bundle: {}: expected a file of `rubicon trust add`", why));
}

Result<std::vector<std::string>> brokers_in(std::string_view text) {
  std::vector<std::string> brokers;
  while (!text.empty()) {
    const auto end = text.find(' ');
    const auto one = text.substr(0, end);
    const auto address = base::parse_host_port(one, kTlsPort);
    if (!address || address->host.empty() || brokers.size() == kMostBrokers)
      return no_site_bundle("has brokers that are no addresses");
    brokers.emplace_back(one);
    text.remove_prefix(end == text.npos ? text.size() : end + 1);
  }
  return brokers;
}

Result<void> check_parts(const SiteBundle& bundle) {
  if (bundle.authority.empty() || bundle.realm.empty()) return no_site_bundle("has no authority, or no realm");
  const bool has_password = !bundle.user.empty() && !bundle.password_hash.empty();
  if (bundle.certificate.empty() != has_password || (has_password && !bundle.key.empty()))
    return no_site_bundle("has neither a certificate nor a user with a password, or both");
  if (!bundle.key.empty() && !bundle.key.starts_with(kProtectedKey))
    return no_site_bundle("has a key that no pass phrase protects");
  return {};
}

}  // namespace

std::string bundle_text(const SiteBundle& bundle) {
  std::string text = fmt::format("{{\"{}\": {}", kSiteFormName, kSiteForm);
  const auto add = [&text](const char* name, std::string_view content) {
    if (content.empty()) return;
    text += fmt::format(",\n \"{}\": ", name);
    model::append_json(content, text);
  };
  for (const auto& [name, part] : kParts) add(name, bundle.*part);
  add(kBrokers, fmt::format("{}", fmt::join(bundle.brokers, " ")));
  return text + "}\n";
}

Result<SiteBundle> read_site_bundle(std::string_view text) {
  if (text.size() > kMaxSiteBundle) return no_site_bundle(fmt::format("has more than {} bytes", kMaxSiteBundle));
  if (base::is_nested_deeper(text, 1)) return no_site_bundle("is no JSON object of texts");
  const auto json = model::parse_json(text);
  if (!json.is_object() || !json.contains(kSiteFormName)) return no_site_bundle("is no JSON object of texts");
  if (json[kSiteFormName] == kDdsForm)
    return fail(
        ErrorCode::kInvalid,
        "the bundle: is of the certificates for DDS of an earlier release, expected one of `rubicon trust add`");
  if (json[kSiteFormName] != kSiteForm) return no_site_bundle("has a form that this release does not know");
  SiteBundle bundle;
  std::size_t known = 1;
  for (const auto& [name, part] : kParts) {
    auto content = model::find_text(json, name);
    if (!content) continue;
    bundle.*part = std::move(*content);
    ++known;
  }
  if (const auto listed = model::find_text(json, kBrokers)) {
    auto brokers = brokers_in(*listed);
    if (!brokers) return fail(brokers.error());
    bundle.brokers = std::move(*brokers);
    ++known;
  }
  if (json.size() != known) return no_site_bundle("has parts that this release does not know");
  if (auto checked = check_parts(bundle); !checked) return fail(checked.error());
  return bundle;
}

}  // namespace rubicon::trust::site
