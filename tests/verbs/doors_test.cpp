#include <algorithm>
#include <map>

#include "console/shell.h"
#include "verbs/requests.h"
#include "web/api/route.h"
#include "web/api/site.h"

namespace rubicon::verbs {
namespace {

using web::api::Json;
using namespace std::chrono_literals;

/// What a door answered: an error, or the tuple that a get showed.
struct DoorAnswer {
  std::string error;  ///< code and text; empty = none
  Json tuple;
};

/// A request, what it is answered with ("" = no error), and what `70000:note` is then. `has_path`: it can be asked by
/// REST, where key and verb are never missing.
struct DoorCase {
  std::string request, error;
  std::string note = "a";
  bool has_path = true;
};

/// The shell, a WebSocket and REST beside the same component, 70000, which lets others set and append.
class Doors : public web::api::Sites {
 protected:
  /// As a new client of a new owner would find it.
  void restore() {
    owner_.erase(Pattern{OwnerId(70000), "**"});
    ASSERT_TRUE(owner_.set("note", "a", {.media_type = "text/x-note"}));
    ASSERT_TRUE(owner_.set("bytes", "\xff\x01", {.media_type = "image/png"}));
    scheduler.run_for(2s);
  }

  DoorAnswer by_socket(Json request) {
    auto& page = Sites::page();
    const auto id = page.ask(std::move(request));
    scheduler.run_for(10s);
    auto answer = read(page.answer(id));
    close(page);
    return answer;
  }
  DoorAnswer by_shell(Json request) {
    lines_.clear();
    request["id"] = 7;
    shell_.line(request.dump());
    scheduler.run_for(10s);
    EXPECT_EQ(lines_.size(), 1U) << request;
    EXPECT_EQ(lines_.empty() ? Json() : lines_[0].value("id", Json()), 7) << request;
    return lines_.empty() ? DoorAnswer() : read(lines_[0]);
  }
  /// The members in path, body, headers and query.
  DoorAnswer by_rest(Json request) {
    const std::string verb = request["do"];
    std::string target = "/api/v1/tuples", body;
    web::Fields headers;
    if (verb == "subscribe") headers.emplace_back("accept", "text/event-stream");
    const auto take = [&request](const char* name) {
      const auto text = request.value(name, "");
      request.erase(name);
      return text;
    };
    if (request.contains("key")) {
      const auto key = take("key");
      const auto colon = key.find(':');
      target += "/" + key.substr(0, colon) + "/" + web::api::percent_encoded(key.substr(colon + 1));
    }
    if (verb == "set" || verb == "append") body = take("value");
    if (const auto media = take("media"); !media.empty()) headers.emplace_back("content-type", media);
    if (verb != "append") request.erase("do");
    for (const auto& [name, value] : request.items()) {
      target += (target.find('?') == target.npos ? "?" : "&") + web::api::percent_encoded(name) + "=" +
                web::api::percent_encoded(value.is_string() ? value.get<std::string>() : value.dump());
    }
    const bool is_write = verb == "set" || verb == "append";
    const auto response = ask(is_write ? "PUT" : "GET", target, body, headers);
    if (response.stream) return {};
    auto tree = Json::parse(response.body);
    DoorAnswer answer{error_in(tree), {}};
    EXPECT_EQ(response.status >= 400, !answer.error.empty()) << response.body;
    if (verb == "get" && answer.error.empty()) answer.tuple = tree;
    return answer;
  }

  std::string note() const { return std::string(owner_.get(OwnerId(70000), "note").value_or(TupleView{}).value); }

 private:
  static std::string error_in(const Json& tree) {
    if (!tree.contains("error")) return {};
    return tree["error"]["code"].get<std::string>() + ": " + tree["error"]["text"].get<std::string>();
  }
  static DoorAnswer read(const Json& answer) {
    EXPECT_TRUE(answer.is_object()) << answer;
    if (!answer.is_object()) return {};
    EXPECT_EQ(answer["ok"], !answer.contains("error")) << answer;
    return {error_in(answer), answer.value("tuple", Json())};
  }

  TupleSpace& owner_ = component(70000);
  tuples::Handle policy_ = owner_.add_policy(
      {OwnerId(70000), "**"}, [](const tuples::RemoteSet&) { return tuples::SetDecision::applied(); },
      tuples::PolicyScope::kSetsAndAppends);
  std::vector<Json> lines_;
  console::Shell shell_{scheduler,
                        component(70001),
                        OwnerId(70000),
                        "proxy",
                        [this](const std::string& line) { lines_.push_back(Json::parse(line)); },
                        [](const std::string&) {},
                        [] {}};
};

const std::vector<DoorCase>& door_cases() {
  static const std::vector<DoorCase> kCases{
      {R"({"do":"set","key":"70000:note","value":"b"})", "", "b"},
      {R"({"do":"set","key":"70000:note","value":""})", "", ""},
      {R"({"do":"set","key":"70000:note","value":"b","sequence":1,"ttl":5,"user":1000.5,"expire":"1h","media":"a/b"})",
       "", "b"},
      {R"({"do":"set","key":"70000:note","value":"b","ttl":"250ms"})", "", "b"},
      {R"({"do":"set","key":"70000:note","value":"b","sequence":4})",
       "refused: writing 'note': expected sequence 4, found sequence 1"},
      {R"({"do":"set","key":"70000:note","value":"b","sequence":-1})",
       "invalid: sequence is '-1'; expected a whole number from 0 to 18446744073709551615"},
      {R"({"do":"set","key":"70000:note","value":"b","sequence":"four"})",
       "invalid: sequence is 'four'; expected a whole number from 0 to 18446744073709551615"},
      {R"({"do":"set","key":"70000:note","value":"b","ttl":"soon"})",
       "invalid: ttl is 'soon'; expected seconds from 0 to 31622400, or a time such as 250ms, 5s or 2min"},
      {R"({"do":"set","key":"70000:note","value":"b","user":"noon"})",
       "invalid: user is 'noon'; expected seconds since 1970, or a time from now such as -1h or 5min"},
      {R"({"do":"set","key":"70000:note","value":"b","expire":1})",
       "out-of-range: expire: expected a time within the next 366 days"},
      {R"({"do":"set","key":"70000:note","value":"b","media":"note"})",
       "invalid: media is 'note'; expected a media type such as text/plain"},
      {R"({"do":"set","key":"70000:note","value":"b","lifetime":"1h"})", "invalid: unknown member 'lifetime'"},
      {R"({"do":"set","key":"70000:note","value":"b","sequnce":1})",
       "invalid: unknown member 'sequnce'; did you mean 'sequence'?"},
      {R"({"do":"set","key":"70000:note","value":"b","b64":"eA=="})", "invalid: value and b64 exclude each other"},
      {R"({"do":"set","key":"70000:note","b64":"eA=="})", "", "x", false},
      {R"({"do":"set","key":"70000:note"})", "invalid: value is missing; expected a text, or bytes as b64", "a", false},
      {R"({"do":"set","value":"b"})", "invalid: key is missing; expected OWNER:KEY, such as 6541:proxy.island", "a",
       false},
      {R"({"do":"set","key":"70000:*","value":"b"})",
       "invalid: key is '70000:*'; expected OWNER:KEY, such as 6541:proxy.island"},
      {R"({"do":"set","key":"0:note","value":"b"})",
       "invalid: key: pattern '0:note': expected an owner id or * before the colon; expected OWNER:KEY, such as "
       "6541:proxy.island"},
      {R"({"do":"set","key":"9:note","value":"b"})", "not-found: no component 9 is present"},
      {R"({"do":"append","key":"70000:note","value":"b"})", "", "ab"},
      {R"({"do":"append","key":"70000:note","value":"b","sequence":2})",
       "refused: writing 'note': expected sequence 2, found sequence 1"},
      {R"({"do":"append","key":"70000:note","value":"b","user":1})", "invalid: unknown member 'user'"},
      {R"({"do":"get","key":"70000:note"})", ""},
      {R"({"do":"get","key":"70000:bytes"})", ""},
      {R"({"do":"get","key":"70000:none"})", "not-found: no tuple 70000:none"},
      {R"({"do":"get","key":"9:note"})", "not-found: no component 9 is present"},
      {R"({"do":"get","key":"70000:a..b"})",
       "invalid: key: key 'a..b': empty part at position 2; expected OWNER:KEY, such as 6541:proxy.island"},
      {R"({"do":"get","key":"70000:note","fresh":true})", "invalid: unknown member 'fresh'"},
      {R"({"do":"subscribe","pattern":"70000:**"})", ""},
      {R"({"do":"subscribe","pattern":"*:note","min":100,"max":"5s","deadband":0.5,"active":true,"full":false})", ""},
      {R"({"do":"subscribe","pattern":"*:note","min":"100ms","passive":true})", ""},
      {R"({"do":"subscribe"})",
       "invalid: pattern is missing; expected OWNER:KEY or *:KEY, such as 6541:proxy.*.*.status or *:proxy.**"},
      {R"({"do":"subscribe","pattern":"a*"})",
       "invalid: pattern: key 'a*': '*' at position 1; parts are [A-Za-z0-9_-]+"},
      {R"({"do":"subscribe","pattern":"*:note","min":-5})",
       "invalid: min is '-5'; expected milliseconds from 0 to 86400000, or a time such as 250ms, 5s or 2min"},
      {R"({"do":"subscribe","pattern":"*:note","max":1})", "invalid: max: expected at least 10ms, or 0 for never"},
      {R"({"do":"subscribe","pattern":"*:note","deadband":"much"})",
       "invalid: deadband is 'much'; expected a number from 0 to 1e+300"},
      {R"({"do":"subscribe","pattern":"*:note","active":"yes"})", "invalid: active is 'yes'; expected true or false"},
      {R"({"do":"subscribe","pattern":"*:note","active":true,"passive":true})",
       "invalid: active and passive exclude each other"},
      {R"({"do":"unsubscribe","subscription":9})", "not-found: no subscription 9", "a", false},
      {R"({"do":"unsubscribe"})", "invalid: subscription is missing; expected its number", "a", false},
      {R"({"do":"sett","key":"70000:note"})", "invalid: do: unknown verb 'sett'; did you mean 'set'?", "a", false},
      {R"({"key":"70000:note"})", "invalid: do is missing; expected a verb, such as subscribe", "a", false},
  };
  return kCases;
}

TEST_F(Doors, OneRequestHasOneOutcomeWhicheverWayItCame) {
  for (const auto& one : door_cases()) {
    const auto request = Json::parse(one.request);
    std::map<std::string, Json> shown;
    const auto check = [&](const std::string& door, const DoorAnswer& answer) {
      EXPECT_EQ(answer.error, one.error) << door << ": " << one.request;
      EXPECT_EQ(note(), one.note) << door << ": " << one.request;
      shown[door] = answer.tuple;
      if (answer.tuple.is_object()) shown[door].erase("write");
    };
    restore();
    check("shell", by_shell(request));
    restore();
    check("WebSocket", by_socket(request));
    if (!one.has_path) continue;
    restore();
    check("REST", by_rest(request));
    EXPECT_EQ(shown["shell"], shown["WebSocket"]);
    EXPECT_EQ(shown["shell"], shown["REST"]);
    EXPECT_EQ(shown["shell"].is_object(), request["do"] == "get" && one.error.empty());
  }
}

TEST_F(Doors, TheWebSocketKnowsEachVerb) {
  restore();
  for (const auto verb : kVerbs) {
    const auto answer = by_socket({{"do", verb}});
    EXPECT_EQ(answer.error.find("unknown verb"), answer.error.npos) << verb;
  }
}

}  // namespace
}  // namespace rubicon::verbs
