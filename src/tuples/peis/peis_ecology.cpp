#include "tuples/peis/peis_ecology.h"

#include <fmt/format.h>

#include <map>
#include <utility>

#include "tuples/peis/peis_link.h"

namespace rubicon::tuples::peis {

namespace {

/// The components of this process.
using Present = std::map<OwnerId, const PeisLink*>;

}  // namespace

struct PeisEcology::Impl {
  PeisLink::Settings settings;
  Scheduler& scheduler;
  transport::Transports& transports;
  base::LogSink& log;
  std::shared_ptr<Present> present = std::make_shared<Present>();
  std::shared_ptr<std::function<void(OwnerId)>> displaced = std::make_shared<std::function<void(OwnerId)>>();
};

namespace {

/// The id of a component of this process, taken until this is destroyed.
std::shared_ptr<void> take(const std::shared_ptr<Present>& present, OwnerId id) {
  present->emplace(id, nullptr);
  return {nullptr, [present, id](void*) { present->erase(id); }};
}

}  // namespace

PeisEcology::PeisEcology(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
PeisEcology::~PeisEcology() = default;

Result<std::unique_ptr<PeisEcology>> PeisEcology::open(PeisOptions options, Scheduler& scheduler,
                                                       transport::Transports& transports, base::LogSink& log,
                                                       PeisMachine machine) {
  auto interfaces = select_interfaces(options, machine.interfaces);
  if (!interfaces) return fail(interfaces.error());
  return std::unique_ptr<PeisEcology>(new PeisEcology(std::make_unique<Impl>(
      Impl{{std::move(options), std::move(*interfaces), std::move(machine)}, scheduler, transports, log})));
}

Result<std::unique_ptr<Link>> PeisEcology::join(OwnerId id) {
  if (id == OwnerId{} || number(id) > kMaxId)
    return fail(ErrorCode::kOutOfRange, fmt::format("PEIS: id {}: expected 1 to {}", number(id), kMaxId));
  if (impl_->present->contains(id))
    return fail(ErrorCode::kDuplicate, fmt::format("component {} is already present in this process", number(id)));
  const auto displaced = [call = std::weak_ptr(impl_->displaced), id] {
    if (const auto listener = call.lock(); listener && *listener) (*listener)(id);
  };
  auto link = std::make_unique<PeisLink>(id, impl_->settings, impl_->scheduler, impl_->transports, impl_->log,
                                         displaced, take(impl_->present, id));
  (*impl_->present)[id] = link.get();
  return link;
}

std::vector<const Presence*> PeisEcology::presences() const {
  std::vector<const Presence*> all;
  for (const auto& [id, link] : *impl_->present) {
    if (const auto* presence = link->presence()) all.push_back(presence);
  }
  return all;
}

void PeisEcology::watch_displaced(std::function<void(OwnerId)> call) {
  *impl_->displaced = std::move(call);
}

}  // namespace rubicon::tuples::peis
