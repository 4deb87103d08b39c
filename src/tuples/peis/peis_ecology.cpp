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
  Result<std::unique_ptr<Link>> join(StandIn who, PeisLink::Settings with);

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
  const auto displaced = [call = std::weak_ptr(impl_->displaced), id] {
    if (const auto listener = call.lock(); listener && *listener) (*listener)(id);
  };
  return impl_->join({id, {}, displaced}, impl_->settings);
}

Result<std::unique_ptr<Link>> PeisEcology::join_as(StandIn who) {
  constexpr std::size_t kMaxConnect = 64;
  auto settings = impl_->settings;
  auto& options = settings.options;
  if (options.listen != 0 && options.connect.size() < kMaxConnect)
    options.connect.push_back(fmt::format("{}:{}", settings.interfaces.front().address, options.listen));
  options.listen = 0;
  settings.shown_host = who.host;
  return impl_->join(std::move(who), std::move(settings));
}

Result<std::unique_ptr<Link>> PeisEcology::Impl::join(StandIn who, PeisLink::Settings with) {
  const auto id = who.id;
  if (id == OwnerId{} || number(id) > kMaxId)
    return fail(ErrorCode::kOutOfRange, fmt::format("PEIS: id {}: expected 1 to {}", number(id), kMaxId));
  if (present->contains(id))
    return fail(ErrorCode::kDuplicate, fmt::format("component {} is already present in this process", number(id)));
  auto link = std::make_unique<PeisLink>(id, std::move(with), scheduler, transports, log, std::move(who.displaced),
                                         take(present, id));
  (*present)[id] = link.get();
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
