#pragma once

#include <gmock/gmock.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/scheduler.h"
#include "scenarios/ecology.h"
#include "web/api/api.h"
#include "web/server/http_text.h"

namespace rubicon::web::api {

using Json = nlohmann::json;
using namespace std::chrono_literals;

/// The other end of a conversation: takes each frame at once, unless read(false) was called.
class Page {
 public:
  Page(Scheduler& scheduler, Api& api, const Caller& caller) : pump_(scheduler, [this] { take(); }) {
    conversation_ = api.open(caller, {[this] { pump_.request(); }, [this](std::string_view why) { closed = why; }});
  }

  /// A request with the next id. The id.
  int ask(Json request) {
    request["id"] = ++last_id_;
    say(request.dump());
    return last_id_;
  }
  void say(std::string_view text) {
    conversation_->received(text);
    take();
  }
  void end() { conversation_.reset(); }

  void read(bool does) {
    reads_ = does;
    take();
  }

  /// The frames that came since the last call.
  std::vector<Json> take_frames() { return std::exchange(frames, {}); }
  /// The one answer to a request so far; a list of all frames with that id if there is not exactly one.
  Json answer(int id) const {
    Json found = Json::array();
    for (const auto& frame : frames) {
      if (frame.value("id", 0) == id) found.push_back(frame);
    }
    return found.size() == 1 ? found[0] : found;
  }

  /// The newest update of each tuple, by key, as a client of one subscription has it.
  std::map<std::string, Json> sets() const {
    std::map<std::string, std::string> keys;
    std::map<std::string, Json> newest;
    for (const auto& frame : frames) {
      const auto introduced = frame.value("k", Json::object());
      for (const auto& [number, key] : introduced.items()) keys[number] = key;
      for (const auto& one : frame.value("set", Json::array())) newest[keys[one[0].dump()]] = one;
    }
    return newest;
  }

  std::vector<Json> frames;
  std::vector<std::string> texts;
  std::string closed;

 private:
  void take() {
    while (reads_ && conversation_) {
      const auto frame = conversation_->next();
      if (!frame) return;
      texts.push_back(*frame);
      frames.push_back(Json::parse(*frame));
    }
  }

  base::OncePerTurn pump_;
  std::unique_ptr<Conversation> conversation_;
  bool reads_ = true;
  int last_id_ = 0;
};

/// Islands and a site beside them, in virtual time.
class Sites : public scenarios::Ecology {
 public:
  static constexpr std::uint32_t kSite = 65536;

  Api& site() {
    if (!api_) api_ = std::make_unique<Api>(scheduler, component(kSite), log, *access, options);
    return *api_;
  }
  Page& page(Role role = Role::kAdmin) {
    pages_.push_back(std::make_unique<Page>(scheduler, site(), Caller{"local", role, "127.0.0.1"}));
    return *pages_.back();
  }
  void close(Page& page) {
    std::erase_if(pages_, [&page](const auto& one) { return one.get() == &page; });
  }
  /// Island 1 with the device `7`: a lamp that measures temperature and light.
  void start_lamp() {
    start_island(1);
    devices_of(1).say("7", lamp());
    scheduler.run_for(100ms);
  }
  void measure(double degrees) {
    devices_of(1).say("7", reading(sensor("temperature"), degrees));
    scheduler.run_ready();
  }

  static constexpr const char* kTemperature = "1:proxy.scripted-1.7.sensor.temperature-1.value";
  static constexpr const char* kSwitch = "1:proxy.scripted-1.7.actuator.switch-1.command";
  /// A request by HTTP, and time until it is answered.
  Response ask(const std::string& method, const std::string& target, const std::string& body = "", Fields headers = {},
               Role role = Role::kAdmin) {
    const auto request = request_of(method, target, body, std::move(headers), role);
    std::optional<Response> response;
    const auto exchange = site().handle(request, [&](Response answer) { response = std::move(answer); });
    for (int i = 0; i < 1200 && !response; ++i) scheduler.run_for(50ms);
    EXPECT_TRUE(response) << method << " " << target;
    return response.value_or(Response{0});
  }
  static Request request_of(const std::string& method, const std::string& target, const std::string& body = "",
                            Fields headers = {}, Role role = Role::kAdmin) {
    auto parsed = server::parse_target(target);
    EXPECT_TRUE(parsed) << target;
    return {method, parsed->path, parsed->query, std::move(headers), body, {"local", role, "127.0.0.1"}};
  }
  Json get(const std::string& target) {
    const auto response = ask("GET", target);
    EXPECT_EQ(response.content_type, "application/json") << response.body;
    return Json::parse(response.body);
  }

  /// From now on callers need a token: `secret`, of `robot` with the role command.
  void need_token() {
    access::AccessRules rules;
    rules.needs_token = true;
    access.emplace(scheduler, std::move(rules));
    access->take({{"robot", Role::kCommand, access::sha256("secret")}});
  }

  std::optional<access::Access> access{std::in_place, scheduler, access::AccessRules{}};
  ApiOptions options{"hall"};

 private:
  std::unique_ptr<Api> api_;
  std::vector<std::unique_ptr<Page>> pages_;
};

}  // namespace rubicon::web::api
