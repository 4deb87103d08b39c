#include "apps/rubicon/knx/bus.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "apps/rubicon/knx/direct_bus.h"
#include "apps/rubicon/tuple_text.h"
#include "model/json_members.h"
#include "model/point_keys.h"
#include "networks/knx/tool_requests.h"

namespace rubicon::cli::knx {

namespace {

using nlohmann::json;

/// A network of an island.
struct NetworkAddress {
  OwnerId island{};
  std::string network;
};

/// Networks of type knx have the id `knx` or `knx-<name>`.
std::vector<NetworkAddress> find_networks(Session& session, const BusOptions& options) {
  std::vector<NetworkAddress> found;
  const auto owner = options.island == 0 ? std::nullopt : std::optional(OwnerId(options.island));
  for (const auto& tuple : session.read({owner, model::IslandKey{session.settings().prefix}.networks()})) {
    const auto names = json::parse(tuple.value, nullptr, false);
    if (!names.is_array()) continue;
    for (const auto& name : names) {
      if (!name.is_string()) continue;
      const auto id = name.get<std::string>();
      const bool fits = options.network.empty() ? id == "knx" || id.starts_with("knx-") : id == options.network;
      if (fits) found.push_back({tuple.owner, id});
    }
  }
  return found;
}

class IslandBus final : public Bus {
 public:
  IslandBus(std::unique_ptr<Session> session, NetworkAddress address)
      : session_(std::move(session)), address_(std::move(address)) {
    for (const auto tag : {networks::knx::kReplyTag, networks::knx::kTelegramTag}) {
      handles_.push_back(session_->client().on_message(tag, [this](const client::UserMessage& message) {
        if (message.from == address_.island) receive(message.type, message.bytes);
      }));
    }
  }
  IslandBus(const IslandBus&) = delete;
  IslandBus& operator=(const IslandBus&) = delete;

  void send(const json& request) override {
    const auto refused = [this, id = model::text_of(request, "id")](const std::string& why) {
      if (!why.empty() && on_reply) on_reply({{"id", id}, {"ok", false}, {"why", why}});
    };
    session_->client().send_to_network(address_.island, address_.network, networks::knx::kRequestTag, request.dump(),
                                       refused);
  }
  bool run(const std::function<bool()>& done, Duration patience) override { return session_->run(done, patience); }
  bool interrupted() const override { return session_->interrupted(); }
  Output& out() override { return session_->out(); }

 private:
  std::unique_ptr<Session> session_;
  NetworkAddress address_;
  std::vector<Handle> handles_;
};

}  // namespace

std::unique_ptr<Bus> Bus::open(const Settings& settings, const BusOptions& options, std::string_view command,
                               int& code) {
  if (!options.direct.empty()) return open_direct(settings, options, code);
  code = kFailed;
  auto session = Session::open(settings, command);
  if (!session) return nullptr;
  auto found = find_networks(*session, options);
  if (found.size() == 1) return std::make_unique<IslandBus>(std::move(session), std::move(found.front()));
  if (found.empty()) {
    code = session->not_found(options.network.empty() ? "no network of type knx" : "no network " + options.network);
    return nullptr;
  }
  std::vector<std::string> names;
  for (const auto& one : found) names.push_back(fmt::format("{} of island {}", one.network, number(one.island)));
  print_error(fmt::format("there are several KNX networks: {}; choose one with --network and --island",
                          fmt::join(names, ", ")));
  code = kUsage;
  return nullptr;
}

void Bus::receive(std::string_view tag, std::string_view text) {
  const auto content = json::parse(text, nullptr, false);
  if (!content.is_object()) return;
  if (tag == networks::knx::kTelegramTag && on_telegram) on_telegram(content);
  if (tag == networks::knx::kReplyTag && on_reply) on_reply(content);
}

json Bus::reply_to(json request, Duration patience) {
  static int last = 0;
  const auto id = std::to_string(++last);
  request["id"] = id;
  std::optional<json> answer;
  on_reply = [&](const json& reply) {
    if (model::text_of(reply, "id") == id) answer = reply;
  };
  send(request);
  run([&] { return answer.has_value(); }, patience);
  on_reply = {};
  return answer ? std::move(*answer)
                : json{{"ok", false}, {"why", interrupted() ? "interrupted" : "no answer in time"}};
}

}  // namespace rubicon::cli::knx
