#include "apps/rubicon-proxy/trust_part.h"

#include <fmt/format.h>

#include <filesystem>

#include "trust/component_ids.h"
#include "trust/operations.h"
#include "trust/private_memory.h"

namespace rubicon::daemon {

namespace {

namespace fs = std::filesystem;
using Choice = config::TrustSetup::Choice;

/// Soon enough to renew in peace.
constexpr int kWarnDays = 30;
/// A certificate has 2^20 ids for tools: the second try succeeds.
constexpr int kMostTries = 16;

}  // namespace

std::string trust_folder(const config::EngineSetup& engine, const std::string& directory) {
  if (!engine.dds || engine.trust.choice == Choice::kNo) return {};
  if (!engine.trust.folder.empty()) return (fs::path(directory) / engine.trust.folder).lexically_normal().string();
  const auto folder = trust::default_folder();
  if (folder) return folder->string();
  return engine.trust.choice == Choice::kYes ? trust::kHostFolder : std::string();
}

std::string ending(const trust::Trust& trust) {
  const int days = trust.days_left();
  if (days >= kWarnDays) return {};
  const auto& name = trust.own().name;
  const auto help = fmt::format(
      "renew it on the host with the authority (rubicon trust dds renew {}), then reload this island", name);
  if (days < 0) return fmt::format("the certificate of {} has ended: no other component sees this one; {}", name, help);
  return fmt::format("the certificate of {} ends in {} day{}; {}", name, days, days == 1 ? "" : "s", help);
}

std::optional<std::vector<std::string>> names_of_members(const std::string& folder, WallTime now) {
  if (folder.empty()) return {};
  const auto there = trust::show(folder, now);
  if (!there || !there->has_authority || !there->unreadable.empty()) return {};
  std::vector<std::string> names;
  for (const auto& one : there->members) {
    if (!one.revoked) names.push_back(one.member.name);
    names.insert(names.end(), one.member.roles.begin(), one.member.roles.end());
  }
  return names;
}

Result<std::shared_ptr<trust::site::LiveRealm>> open_realm(const tuples::mqtt::SpaceOptions& space,
                                                           Scheduler& scheduler, LogSink& sink) {
  const auto& broker = space.brokers.front();
  const auto& tls = broker.line.tls;
  return trust::site::LiveRealm::open(tls ? tls->ca_file : "", broker.user, scheduler, Log(sink, "mqtt"));
}

Result<void> TrustPart::open(const std::string& folder, IslandId island) {
  if (folder.empty()) return {};
  trust::keep_memory_private();
  auto place = trust::place_of_island(folder, island);
  if (!place) return fail(ErrorCode::kIo, place.error().text);
  auto opened = trust::Trust::open(std::move(*place), scheduler_, Log(sink_, "trust"));
  if (!opened) return fail(ErrorCode::kIo, opened.error().text);
  trust_ = std::move(*opened);
  taken_.insert(island);
  log_.info(fmt::format("this island is {} by the certificate in {}, with {} days left", trust_->own().name, folder,
                        trust_->days_left()));
  return {};
}

OwnerId TrustPart::component_id(OwnerId otherwise) {
  if (!trust_) return otherwise;
  for (int i = 0; i < kMostTries; ++i) {
    const auto id = trust::random_id(trust_->own());
    if (id != model::kNoOwner && taken_.insert(id).second) return id;
  }
  return otherwise;
}

}  // namespace rubicon::daemon
