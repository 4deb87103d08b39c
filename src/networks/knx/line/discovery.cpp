#include "networks/knx/line/discovery.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace rubicon::networks::knx::line {

namespace {

using transport::Endpoint;
using transport::UdpCalls;
using transport::UdpOptions;

/// Problems are for people: nobody reads more of them.
constexpr std::size_t kMostProblems = 100;
constexpr int kTries = 2;

/// The blocks an extended search asks for: device, families, secured families, tunnels.
wire::Srp wanted_dibs() {
  return {wire::Srp::Type::kWantedDibs, false, {0x01, 0x02, 0x06, 0x07}};
}

/// Servers of Core version 2 answer an extended search (KNX 3/8/2).
bool knows_extended_search(const wire::ServerDescription& description) {
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

struct Discovery::Question {
  Endpoint host;    ///< as it was given
  Endpoint remote;  ///< numeric
  std::unique_ptr<transport::Lookup> lookup;
  std::unique_ptr<transport::UdpSocket> socket;
  Timer patience;
  int tries = 0;
  bool described = false;  ///< the description is there; what an extended search adds is awaited
  bool over = false;
};

Discovery::Discovery(Scheduler& scheduler, transport::Transports& transports, DiscoveryOptions options, Done done)
    : scheduler_(scheduler), transports_(transports), options_(std::move(options)), done_(std::move(done)) {
  for (const auto& address : options_.interfaces) search(address);
  for (const auto& host : options_.hosts) ask(host);
  if (!searches_.empty()) {
    collecting_ = true;
    repeat_ = scheduler_.after(options_.repeat, [this] {
      for (const auto& one : searches_) say(*one);
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
  calls.received = [this](const Endpoint& from, ByteView bytes) { heard(from, bytes); };
  calls.undelivered = [](const Error&) {};  // nobody answers to a group: that is no news
  calls.failed = [this](Error error) { problem(std::move(error)); };
  auto socket = transports_.open_udp(options, std::move(calls));
  if (!socket)
    return problem(
        {socket.error().code, fmt::format("interface {} is not searched: {}", interface_address, socket.error().text)});
  searches_.push_back(std::make_unique<Search>(Search{interface_address, std::move(*socket)}));
  say(*searches_.back());
}

void Discovery::say(Search& search) {
  const auto own =
      options_.route_back ? wire::Hpai{} : wire::udp_hpai(search.interface_address, search.socket->local().port);
  for (const auto& request : {wire::SearchRequest{own, false, {}}, wire::SearchRequest{own, true, {wanted_dibs()}}}) {
    if (auto sent = search.socket->send(options_.group, write(wire::Message(request))); !sent)
      problem({sent.error().code,
               fmt::format("interface {} is not searched: {}", search.interface_address, sent.error().text)});
  }
}

void Discovery::heard(const Endpoint& from, ByteView frame) {
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

void Discovery::ask(const Endpoint& host) {
  auto& question = *questions_.emplace_back(std::make_unique<Question>());
  question.host = host;
  question.lookup =
      transports_.look_up(host.address, [this, &question](const auto& addresses) { resolved(question, addresses); });
}

void Discovery::resolved(Question& question, const Result<std::vector<std::string>>& addresses) {
  if (!addresses) {
    question.over = true;
    problem(addresses.error());
    return finish_if_done();
  }
  const auto four = std::find_if(addresses->begin(), addresses->end(),
                                 [](const std::string& one) { return one.find(':') == one.npos; });
  if (four == addresses->end()) return unanswered(question, "it has no IPv4 address");
  question.remote = {*four, question.host.port};
  open(question);
}

/// Connected, so that it knows its own address, and hears when nobody is there.
void Discovery::open(Question& question) {
  UdpOptions options;
  options.remote = question.remote;
  UdpCalls calls;
  calls.received = [this, &question](const Endpoint& from, ByteView bytes) { answered(question, from, bytes); };
  calls.undelivered = [this, &question](const Error&) { unanswered(question, "nobody listens there"); };
  calls.failed = [this, &question](const Error& error) { unanswered(question, error.text); };
  auto socket = transports_.open_udp(options, std::move(calls));
  if (!socket) return unanswered(question, socket.error().text);
  question.socket = std::move(*socket);
  send(question);
}

/// The second time it asks for the answer to where the question came from: an address may be translated on the way.
void Discovery::send(Question& question) {
  const bool route_back = options_.route_back || question.tries > 0;
  const auto local = question.socket->local();
  ++question.tries;
  const wire::DescriptionRequest request{route_back ? wire::Hpai{} : wire::udp_hpai(local.address, local.port)};
  if (auto sent = question.socket->send(question.remote, write(wire::Message(request))); !sent)
    return unanswered(question, sent.error().text);
  question.patience = scheduler_.after(options_.description, [this, &question] {
    if (question.tries < kTries) return send(question);
    const auto waited = std::chrono::duration<double>(options_.description * kTries).count();
    unanswered(question, fmt::format("no answer within {} s", waited));
  });
}

void Discovery::unanswered(Question& question, const std::string& why) {
  if (question.over) return;
  if (!question.described)
    problem({ErrorCode::kUnreachable, fmt::format("{} does not describe itself: {}", to_string(question.host), why)});
  end(question);
}

void Discovery::answered(Question& question, const Endpoint& from, ByteView frame) {
  if (question.over) return;
  const auto message = wire::read_message(frame);
  const auto* described = message ? std::get_if<wire::DescriptionResponse>(&*message) : nullptr;
  const auto* found = message ? std::get_if<wire::SearchResponse>(&*message) : nullptr;
  const bool awaited = question.described ? found != nullptr : described != nullptr;
  if (!awaited) {
    result_.bad_frames += described == nullptr && found == nullptr ? 1 : 0;
    return;
  }
  const auto description = wire::read_description(described ? described->dibs : found->dibs);
  if (!servers_.add(from, description, found != nullptr)) ++result_.bad_frames;
  if (described != nullptr && knows_extended_search(description)) return ask_more(question);
  end(question);
}

/// A description leaves out what is secured and which tunnels are free; the extended search has both, of one host too.
void Discovery::ask_more(Question& question) {
  question.described = true;
  const auto local = question.socket->local();
  const auto own = question.tries > 1 || options_.route_back ? wire::Hpai{} : wire::udp_hpai(local.address, local.port);
  const wire::SearchRequest request{own, true, {wanted_dibs()}};
  if (!question.socket->send(question.remote, write(wire::Message(request)))) return end(question);
  question.patience = scheduler_.after(options_.description, [this, &question] { end(question); });
}

void Discovery::end(Question& question) {
  question.over = true;
  question.patience.cancel();
  finish_if_done();
}

void Discovery::problem(Error error) {
  auto& all = result_.problems;
  if (all.size() < kMostProblems && std::find(all.begin(), all.end(), error) == all.end())
    all.push_back(std::move(error));
}

/// In a later turn, where sockets and questions may be destroyed.
void Discovery::finish_if_done() {
  const bool asked = std::all_of(questions_.begin(), questions_.end(), [](const auto& one) { return one->over; });
  if (collecting_ || !asked || finish_.pending()) return;
  finish_ = scheduler_.after(Duration::zero(), [this] {
    result_.servers = servers_.all();
    const auto done = std::move(done_);
    done(std::move(result_));
  });
}

}  // namespace rubicon::networks::knx::line
