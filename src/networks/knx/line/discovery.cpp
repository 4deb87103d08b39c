#include "networks/knx/line/discovery.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace rubicon::networks::knx::line {

namespace {

using transport::Endpoint;
using transport::UdpCalls;
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
  UdpCalls calls;
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
  UdpCalls calls;
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
