#include "trust/bundle.h"

#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/json_depth.h"
#include "model/json_members.h"
#include "model/json_text.h"

namespace rubicon::trust {

namespace {

constexpr int kBundleForm = 1;
constexpr int kSiteForm = 2;  // trust/site
constexpr const char* kFormName = "rubicon-trust";
constexpr const char* kKeyName = "key";
constexpr std::string_view kEncryptedKey = "-----BEGIN ENCRYPTED PRIVATE KEY-----\n";

/// The papers by their names in the file.
constexpr std::array<std::pair<const char*, Paper Papers::*>, 6> kPapers{{{"identity-ca", &Papers::identity_ca},
                                                                          {"permissions-ca", &Papers::permissions_ca},
                                                                          {"governance", &Papers::governance},
                                                                          {"revoked", &Papers::revoked},
                                                                          {"certificate", &Papers::certificate},
                                                                          {"permissions", &Papers::permissions}}};

tl::unexpected<Error> no_bundle(std::string_view why) {
  return fail(ErrorCode::kInvalid, fmt::format("the bundle: {}: expected a file of `rubicon trust`", why));
}

}  // namespace

std::string bundle_text(const Bundle& bundle) {
  std::string text = fmt::format("{{\"{}\": {}", kFormName, kBundleForm);
  const auto add = [&text](const char* name, std::string_view content) {
    text += fmt::format(",\n \"{}\": ", name);
    model::append_json(content, text);
  };
  for (const auto& [name, paper] : kPapers) add(name, (bundle.papers.*paper).text);
  if (!bundle.key.empty()) add(kKeyName, bundle.key);
  return text + "}\n";
}

Result<Bundle> read_bundle(std::string_view text) {
  if (text.size() > kLargestBundle) return no_bundle(fmt::format("has more than {} bytes", kLargestBundle));
  if (base::is_nested_deeper(text, 1)) return no_bundle("is no JSON object of texts");
  const auto json = model::parse_json(text);
  if (!json.is_object() || !json.contains(kFormName)) return no_bundle("is no JSON object of texts");
  if (json[kFormName] == kSiteForm)
    return fail(ErrorCode::kInvalid, "the bundle: is one of MQTT brokers: `rubicon trust join` takes it");
  if (json[kFormName] != kBundleForm) return no_bundle("has a form that this release does not know");
  Bundle bundle;
  for (const auto& [name, paper] : kPapers) {
    auto content = model::find_text(json, name);
    if (!content) return no_bundle(fmt::format("has no `{}`", name));
    bundle.papers.*paper = {std::move(*content), fmt::format("the bundle: {}", name)};
  }
  const auto key = model::find_text(json, kKeyName);
  if (json.size() != kPapers.size() + (key ? 2U : 1U)) return no_bundle("has parts that this release does not know");
  if (key && !key->starts_with(kEncryptedKey)) return no_bundle("has a key that no pass phrase protects");
  bundle.key = key.value_or("");
  return bundle;
}

}  // namespace rubicon::trust
