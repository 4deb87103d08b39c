#include "networks/knx/line/discovery.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

namespace rubicon::networks::knx::line {

namespace {

template <std::size_t size>
bool is_set(const std::array<std::uint8_t, size>& bytes) {
  return bytes != std::array<std::uint8_t, size>{};
}

void merge_families(std::vector<wire::FamilyVersion>& into, const std::vector<wire::FamilyVersion>& more) {
  for (const auto& family : more) {
    const auto known =
        std::find_if(into.begin(), into.end(), [&](const auto& one) { return one.family == family.family; });
    if (known == into.end()) {
      into.push_back(family);
    } else {
      known->version = std::max(known->version, family.version);
    }
  }
}

std::string families_text(const std::vector<wire::FamilyVersion>& families) {
  std::vector<std::string> words;
  words.reserve(families.size());
  for (const auto& [family, version] : families) words.push_back(fmt::format("{} {}", to_string(family), version));
  return fmt::format("{}", fmt::join(words, ", "));
}

std::string slot_text(const wire::TunnelSlot& slot) {
  const auto* state = !slot.usable ? "not usable" : slot.free ? "free" : "used";
  return fmt::format("{} {}{}", to_string(slot.address), state, slot.authorised ? "" : " (needs authorisation)");
}

std::string slots_text(const FoundServer& server) {
  const auto& slots = server.description.slots;
  std::vector<std::string> words;
  words.reserve(slots.size());
  for (const auto& slot : slots) words.push_back(slot_text(slot));
  return fmt::format("{} of {} free: {}", server.free_slots(), slots.size(), fmt::join(words, ", "));
}

/// What to configure where plain connections are refused.
std::string remedy_text(const wire::ServerDescription& about) {
  const auto secured = [&](wire::Family family) {
    return std::any_of(about.secured.begin(), about.secured.end(),
                       [&](const auto& one) { return one.family == family; });
  };
  const bool tunnelling = secured(wire::Family::kTunnelling), routing = secured(wire::Family::kRouting);
  if (!tunnelling && !routing) return "KNX IP Secure is required";
  return fmt::format("KNX IP Secure is required: configure {}`keyring: FILE.knxkeys`",
                     tunnelling ? "`via: tunnel-tcp` and " : "");
}

std::string security_text(const FoundServer& server) {
  switch (server.security()) {
    case Security::kRequired:
      return fmt::format("{} ({})", families_text(server.description.secured), remedy_text(server.description));
    case Security::kPossible: return "possible, not required";
    case Security::kNone: return "not required";
    case Security::kUnknown: break;
  }
  return {};
}

std::string mac_text(const std::array<std::uint8_t, 6>& mac) {
  return fmt::format("{:02x}", fmt::join(mac, ":"));
}

}  // namespace

std::size_t FoundServer::free_slots() const {
  return static_cast<std::size_t>(std::count_if(description.slots.begin(), description.slots.end(),
                                                [](const auto& slot) { return slot.usable && slot.free; }));
}

Security FoundServer::security() const {
  if (!description.secured.empty()) return Security::kRequired;
  if (!extended) return Security::kUnknown;
  return description.version(wire::Family::kSecurity) != 0 ? Security::kPossible : Security::kNone;
}

std::string_view to_string(Security security) {
  switch (security) {
    case Security::kUnknown: break;
    case Security::kNone: return "none";
    case Security::kPossible: return "possible";
    case Security::kRequired: return "required";
  }
  return "unknown";
}

void merge(wire::ServerDescription& into, const wire::ServerDescription& more) {
  if (more.medium != 0) {  // the answer describes the device
    into.medium = more.medium;
    into.programming_mode = more.programming_mode;
    into.address = more.address;
    into.project = more.project;
  }
  if (is_set(more.serial)) into.serial = more.serial;
  if (is_set(more.mac)) into.mac = more.mac;
  if (is_set(more.multicast)) into.multicast = more.multicast;
  if (!more.name.empty()) into.name = more.name;
  merge_families(into.families, more.families);
  merge_families(into.secured, more.secured);
  if (!more.addresses.empty()) into.addresses = more.addresses;
  if (more.max_apdu) into.max_apdu = more.max_apdu;
  if (!more.slots.empty()) into.slots = more.slots;
}

bool FoundServers::add(const transport::Endpoint& control, const wire::ServerDescription& description, bool extended) {
  auto known = std::find_if(servers_.begin(), servers_.end(), [&](const auto& one) { return one.control == control; });
  if (known == servers_.end()) {
    if (servers_.size() >= kMaxServers) return false;
    known = servers_.insert(servers_.end(), FoundServer{control, {}, false});
  }
  merge(known->description, description);
  known->extended = known->extended || extended;
  return true;
}

std::string medium_name(std::uint8_t medium) {
  switch (medium) {
    case 0x00: return "unknown medium";
    case 0x02: return "TP1";
    case 0x04: return "PL110";
    case 0x10: return "RF";
    case 0x20: return "IP";
    default: return fmt::format("medium {:02x}", medium);
  }
}

std::string describe(const FoundServer& server) {
  const auto& about = server.description;
  auto text = fmt::format("{}  {}  {}  {}{}", about.name.empty() ? "(no name)" : about.name, to_string(server.control),
                          to_string(about.address), medium_name(about.medium),
                          about.programming_mode ? "  in programming mode" : "");
  const auto line = [&](std::string_view what, const std::string& value) {
    text += fmt::format("\n  {:<10} {}", what, value);
  };
  if (is_set(about.serial)) line("serial", base::to_hex(about.serial));
  if (is_set(about.mac)) line("MAC", mac_text(about.mac));
  if (is_set(about.multicast)) line("group", fmt::format("{}", fmt::join(about.multicast, ".")));
  if (!about.families.empty()) line("families", families_text(about.families));
  if (const auto secure = security_text(server); !secure.empty()) line("secure", secure);
  if (about.max_apdu) line("max APDU", fmt::format("{} bytes", *about.max_apdu));
  if (!about.slots.empty()) line("tunnels", slots_text(server));
  if (about.slots.empty() && !about.addresses.empty()) {
    std::vector<std::string> words;
    words.reserve(about.addresses.size());
    for (const auto address : about.addresses) words.push_back(to_string(address));
    line("addresses", fmt::format("{}", fmt::join(words, ", ")));
  }
  return text;
}

namespace {

using transport::Endpoint;
using transport::UdpCallbacks;
using transport::UdpOptions;

/// Problems are shown to the user; more of them help no one.
constexpr std::size_t kMaxProblems = 100;
constexpr int kMaxQueryAttempts = 2;

/// The blocks that an extended search asks for: device, families, secured families, tunnels.
wire::Srp wanted_dibs() {
  return {wire::Srp::Type::kWantedDibs, false, {0x01, 0x02, 0x06, 0x07}};
}

/// Servers of Core version 2 answer an extended search (KNX 3/8/2).
bool supports_extended_search(const wire::ServerDescription& description) {
  return std::any_of(description.families.begin(), description.families.end(), [](const wire::FamilyVersion& one) {
    return one.family == wire::Family::kCore && one.version >= 2;
  });
}

Endpoint endpoint_of(const wire::Hpai& hpai, const Endpoint& from) {
  if (hpai.route_back()) return from;
  return {address_text(hpai), hpai.port};
}

}  // namespace

struct Discovery::Search {
  std::string interface_address;
  std::unique_ptr<transport::UdpSocket> socket;
};

struct Discovery::Query {
  Endpoint host;    ///< as it was given
  Endpoint remote;  ///< numeric
  std::unique_ptr<transport::Lookup> lookup;
  std::unique_ptr<transport::UdpSocket> socket;
  Timer timeout;
  int attempts = 0;
  bool described = false;  ///< described, the answer to the extended search is awaited
  bool finished = false;
};

Discovery::Discovery(Scheduler& scheduler, transport::Transports& transports, DiscoveryOptions options, Done done)
    : scheduler_(scheduler), transports_(transports), options_(std::move(options)), done_(std::move(done)) {
  for (const auto& address : options_.interfaces) search(address);
  for (const auto& host : options_.hosts) ask_host(host);
  if (!searches_.empty()) {
    collecting_ = true;
    repeat_ = scheduler_.after(options_.repeat, [this] {
      for (const auto& one : searches_) send_search(*one);
    });
    end_ = scheduler_.after(options_.collect, [this] {
      collecting_ = false;
      searches_.clear();
      finish_if_done();
    });
  }
  finish_if_done();
}

Discovery::~Discovery() = default;

void Discovery::search(const std::string& interface_address) {
  UdpOptions options{{interface_address, 0}};
  options.multicast = transport::UdpMulticast{{}, interface_address, options_.ttl};
  UdpCallbacks calls;
  calls.received = [this](const Endpoint& from, ByteView bytes) { receive(from, bytes); };
  calls.undelivered = [](const Error&) {};  // multicast datagrams need not arrive
  calls.failed = [this](Error error) { problem(std::move(error)); };
  auto socket = transports_.open_udp(options, std::move(calls));
  if (!socket)
    return problem({socket.error().code,
                    fmt::format("interface {} cannot be searched: {}", interface_address, socket.error().text)});
  searches_.push_back(std::make_unique<Search>(Search{interface_address, std::move(*socket)}));
  send_search(*searches_.back());
}

void Discovery::send_search(Search& search) {
  const auto own =
      options_.route_back ? wire::Hpai{} : wire::udp_hpai(search.interface_address, search.socket->local().port);
  for (const auto& request : {wire::SearchRequest{own, false, {}}, wire::SearchRequest{own, true, {wanted_dibs()}}}) {
    if (auto sent = search.socket->send(options_.group, write(wire::Message(request))); !sent)
      problem({sent.error().code,
               fmt::format("interface {} cannot be searched: {}", search.interface_address, sent.error().text)});
  }
}

void Discovery::receive(const Endpoint& from, ByteView frame) {
  const auto message = wire::read_message(frame);
  if (!message) {
    ++result_.bad_frames;
    return;
  }
  const auto* response = std::get_if<wire::SearchResponse>(&*message);
  if (response == nullptr) return;
  const auto description = wire::read_description(response->dibs);
  if (!servers_.add(endpoint_of(response->control, from), description, response->extended)) ++result_.bad_frames;
}

void Discovery::ask_host(const Endpoint& host) {
  auto& query = *queries_.emplace_back(std::make_unique<Query>());
  query.host = host;
  query.lookup =
      transports_.look_up(host.address, [this, &query](const auto& addresses) { resolved(query, addresses); });
}

void Discovery::resolved(Query& query, const Result<std::vector<std::string>>& addresses) {
  if (!addresses) {
    query.finished = true;
    problem(addresses.error());
    return finish_if_done();
  }
  const auto four = std::find_if(addresses->begin(), addresses->end(),
                                 [](const std::string& one) { return one.find(':') == one.npos; });
  if (four == addresses->end()) return unanswered(query, "it has no IPv4 address");
  query.remote = {*four, query.host.port};
  open(query);
}

/// The socket is connected, so that it knows its own address and learns whether the port is closed.
void Discovery::open(Query& query) {
  UdpOptions options;
  options.remote = query.remote;
  UdpCallbacks calls;
  calls.received = [this, &query](const Endpoint& from, ByteView bytes) { answered(query, from, bytes); };
  calls.undelivered = [this, &query](const Error&) { unanswered(query, "no program listens on that port"); };
  calls.failed = [this, &query](const Error& error) { unanswered(query, error.text); };
  auto socket = transports_.open_udp(options, std::move(calls));
  if (!socket) return unanswered(query, socket.error().text);
  query.socket = std::move(*socket);
  send(query);
}

/// The second attempt asks for an answer to the source of the request: a router may translate the address.
void Discovery::send(Query& query) {
  const bool route_back = options_.route_back || query.attempts > 0;
  const auto local = query.socket->local();
  ++query.attempts;
  const wire::DescriptionRequest request{route_back ? wire::Hpai{} : wire::udp_hpai(local.address, local.port)};
  if (auto sent = query.socket->send(query.remote, write(wire::Message(request))); !sent)
    return unanswered(query, sent.error().text);
  query.timeout = scheduler_.after(options_.description, [this, &query] {
    if (query.attempts < kMaxQueryAttempts) return send(query);
    const auto waited = std::chrono::duration<double>(options_.description * kMaxQueryAttempts).count();
    unanswered(query, fmt::format("no answer within {} s", waited));
  });
}

void Discovery::unanswered(Query& query, const std::string& why) {
  if (query.finished) return;
  if (!query.described)
    problem({ErrorCode::kUnreachable, fmt::format("{} does not describe itself: {}", to_string(query.host), why)});
  end(query);
}

void Discovery::answered(Query& query, const Endpoint& from, ByteView frame) {
  if (query.finished) return;
  const auto message = wire::read_message(frame);
  const auto* described = message ? std::get_if<wire::DescriptionResponse>(&*message) : nullptr;
  const auto* found = message ? std::get_if<wire::SearchResponse>(&*message) : nullptr;
  const bool awaited = query.described ? found != nullptr : described != nullptr;
  if (!awaited) {
    result_.bad_frames += described == nullptr && found == nullptr ? 1 : 0;
    return;
  }
  const auto description = wire::read_description(described ? described->dibs : found->dibs);
  if (!servers_.add(from, description, found != nullptr)) ++result_.bad_frames;
  if (described != nullptr && supports_extended_search(description)) return search_host(query);
  end(query);
}

/// A description does not say what is secured and which tunnels are free. An extended search of this host does.
void Discovery::search_host(Query& query) {
  query.described = true;
  const auto local = query.socket->local();
  const auto own = query.attempts > 1 || options_.route_back ? wire::Hpai{} : wire::udp_hpai(local.address, local.port);
  const wire::SearchRequest request{own, true, {wanted_dibs()}};
  if (!query.socket->send(query.remote, write(wire::Message(request)))) return end(query);
  query.timeout = scheduler_.after(options_.description, [this, &query] { end(query); });
}

void Discovery::end(Query& query) {
  query.finished = true;
  query.timeout.cancel();
  finish_if_done();
}

void Discovery::problem(Error error) {
  auto& all = result_.problems;
  if (all.size() < kMaxProblems && std::find(all.begin(), all.end(), error) == all.end())
    all.push_back(std::move(error));
}

/// Calls `done` in a later turn, where sockets and queries may be destroyed.
void Discovery::finish_if_done() {
  const bool answered = std::all_of(queries_.begin(), queries_.end(), [](const auto& one) { return one->finished; });
  if (collecting_ || !answered || finish_.pending()) return;
  finish_ = scheduler_.after(Duration::zero(), [this] {
    result_.servers = servers_.all();
    const auto done = std::move(done_);
    done(std::move(result_));
  });
}

}  // namespace rubicon::networks::knx::line
