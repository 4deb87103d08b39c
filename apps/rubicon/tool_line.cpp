#include "apps/rubicon/tool_line.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "apps/rubicon/output/tuple_text.h"
#include "model/json_members.h"
#include "model/json_text.h"
#include "model/point_keys.h"

namespace rubicon::cli {

namespace {

using nlohmann::json;

/// A network of an island.
struct NetworkAddress {
  OwnerId island{};
  std::string network;
};

/// Networks of a type have the id `<type>` or `<type>-<name>`.
std::vector<NetworkAddress> find_networks(Session& session, const NetworkChoice& choice) {
  std::vector<NetworkAddress> found;
  for (const auto& tuple :
       session.read({choice.island.owner(), model::IslandKey{session.settings().prefix}.networks()})) {
    const auto names = model::parse_json(tuple.value);
    if (!names.is_array()) continue;
    for (const auto& name : names) {
      if (!name.is_string()) continue;
      const auto id = name.get<std::string>();
      const bool of_type = id == choice.type || id.starts_with(choice.type + "-");
      if (choice.network.empty() ? of_type : id == choice.network) found.push_back({tuple.owner, id});
    }
  }
  return found;
}

class IslandToolLine final : public ToolLine {
 public:
  IslandToolLine(std::unique_ptr<Session> session, NetworkAddress address, const ToolTags& tags)
      : ToolLine(tags), session_(std::move(session)), address_(std::move(address)) {
    for (const auto tag : {tags.reply, tags.event}) {
      handles_.push_back(session_->client().on_message(tag, [this](const client::UserMessage& message) {
        if (message.from == address_.island) receive(message.type, message.bytes);
      }));
    }
  }

  void send(const json& request) override {
    const auto refuse = [this, id = model::text_of(request, "id")](const std::string& why) {
      if (!why.empty() && on_reply) on_reply({{"id", id}, {"ok", false}, {"why", why}});
    };
    session_->client().send_to_network(address_.island, address_.network, tags().tag_of(request), model::dump(request),
                                       refuse);
  }
  bool run(const std::function<bool()>& done, Duration patience) override { return session_->run(done, patience); }
  bool interrupted() const override { return session_->interrupted(); }
  void resume() override { session_->resume(); }
  Output& out() override { return session_->out(); }
  std::vector<client::Device> devices() override {
    client::DeviceQuery query;
    query.island = address_.island;
    query.network = address_.network;
    return session_->client().devices(query, session_->settings().patience);
  }

 private:
  std::unique_ptr<Session> session_;
  NetworkAddress address_;
  std::vector<Handle> handles_;
};

}  // namespace

CLI::Option* NetworkChoice::add_to(CLI::App* app, const std::string& example) {
  island.add_to(app, "use the line of this island: id or name");
  return app->add_option("--network", network, fmt::format("use this network: {0}, 6541:{0}", example))
      ->type_name("[ISLAND:]ID");
}

std::unique_ptr<ToolLine> open_tool_line(const Settings& settings, std::string_view command, NetworkChoice choice,
                                         const ToolTags& tags, int& code) {
  code = kFailed;
  auto session = Session::open(settings, command);
  if (!session) return nullptr;
  if (code = choice.island.find(*session, choice.network); code != kGood) return nullptr;
  auto found = find_networks(*session, choice);
  if (found.size() == 1) return std::make_unique<IslandToolLine>(std::move(session), std::move(found.front()), tags);
  if (found.empty()) {
    code = session->not_found(choice.network.empty() ? "no network of type " + choice.type
                                                     : "no network " + choice.network);
    return nullptr;
  }
  std::vector<std::string> names;
  for (const auto& one : found) names.push_back(fmt::format("{} of island {}", one.network, number(one.island)));
  print_error(fmt::format("there are several networks of type {}: {}; choose one with --network and --island",
                          choice.type, fmt::join(names, ", ")));
  code = kUsage;
  return nullptr;
}

void ToolLine::receive(std::string_view tag, std::string_view text) {
  const auto content = model::parse_json(text);
  if (!content.is_object()) return;
  if (tag == tags_.event && on_event) on_event(content);
  if (tag == tags_.reply && on_reply) on_reply(content);
}

json ToolLine::reply_to(json request, Duration patience) {
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

namespace {

/// A monitor's lease, renewed long before it ends.
constexpr int kLeaseSeconds = 30;
constexpr Duration kRenew = std::chrono::seconds(10);
/// For the network's reply to the end of a monitor.
constexpr Duration kEnd = std::chrono::seconds(1);
constexpr const char* kMonitorId = "monitor";

/// The network then sends nothing to a tool that is gone.
void end_monitor(ToolLine& line) {
  bool ended = false;
  line.on_event = {};
  line.on_reply = [&ended](const json&) { ended = true; };
  line.send({{"do", "monitor"}, {"seconds", 0}, {"id", kMonitorId}});
  line.resume();
  line.run([&ended] { return ended; }, kEnd);
}

}  // namespace

int monitor_traffic(ToolLine& line) {
  const json request{{"do", "monitor"}, {"seconds", kLeaseSeconds}, {"id", kMonitorId}};
  bool refusal = false;
  line.on_reply = [&](const json& reply) {
    if (model::flag_of(reply, "ok") || refusal) return;
    refusal = true;
    refused(reply);
  };
  do {
    line.send(request);
    line.run([&] { return refusal; }, kRenew);
  } while (!refusal && !line.interrupted() && !line.out().broken());
  if (!refusal) end_monitor(line);
  return refusal ? kNotDone : kGood;
}

int refused(const json& reply) {
  print_error(printable(model::text_of(reply, "why")));
  return kNotDone;
}

}  // namespace rubicon::cli
