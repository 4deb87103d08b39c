#include "tuples/peis/peis_ecology.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <map>
#include <utility>

#include "base/text.h"
#include "transport/host_names.h"
#include "tuples/peis/peis_link.h"
#include "tuples/refusals.h"

namespace rubicon::tuples::peis {

using namespace std::chrono_literals;

namespace {

constexpr std::size_t kMaxHostText = 253;  // RFC 1035, 2.3.4

}  // namespace

Result<std::string> connect_target(std::string_view url) {
  constexpr std::string_view kScheme = "tcp://";
  const auto where = url.substr(url.starts_with(kScheme) ? kScheme.size() : 0);
  const auto parsed = base::parse_host_port(where, kFirstListenPort);
  const auto is_of_names = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' || c == '-';
  };
  if (parsed && !parsed->host.empty() && parsed->host.size() <= kMaxHostText &&
      std::all_of(parsed->host.begin(), parsed->host.end(), is_of_names))
    return std::string(where);
  return fail(ErrorCode::kInvalid, "expected tcp://host:port, the host as a name or an IPv4 address");
}

bool leaves_loopback(const std::vector<std::string>& interfaces, std::string_view target) {
  const auto where = base::parse_host_port(target, kFirstListenPort);
  return interfaces == std::vector<std::string>{"lo"} && where && transport::is_numeric_address_text(where->host) &&
         !transport::is_loopback_address(where->host);
}

PeisMachine PeisMachine::own() {
  auto name = transport::host_name();
  name = name.substr(0, std::min(name.find('.'), kMaxNameLength));
  if (name.empty()) name = "localhost";
  const auto process = transport::own_process();  // `pid 4711 of anna`
  const auto of = process.find(" of ");
  return {transport::ipv4_interfaces(), std::move(name), transport::host_id("host"), std::to_string(::getpid()),
          of == process.npos ? std::string() : process.substr(of + 4)};
}

Result<std::vector<transport::Interface>> select_interfaces(const PeisOptions& options,
                                                            const std::vector<transport::Interface>& present) {
  if (options.lease < 500ms || options.lease > 60s)
    return fail(ErrorCode::kOutOfRange, "PEIS: lease: expected 500 ms to 60 s");
  std::vector<transport::Interface> selected;
  for (const auto& name : options.interfaces) {
    const auto before = selected.size();
    for (const auto& interface : present) {
      if (interface.name == name && interface.is_up && !interface.address.empty()) selected.push_back(interface);
    }
    if (selected.size() == before)
      return fail(ErrorCode::kNotFound, fmt::format("PEIS: no interface '{}' is up with an IPv4 address", name));
  }
  if (selected.empty() || selected.size() > kMaxAddresses)
    return fail(ErrorCode::kOutOfRange,
                fmt::format("PEIS: {} addresses on the interfaces, expected 1 to {}", selected.size(), kMaxAddresses));
  return selected;
}

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
  if (present->contains(id)) return fail(already_here(id));
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
