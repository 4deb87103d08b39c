#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "web/server/client.h"

namespace rubicon::web::server {

/// A conversation whose frames a test writes.
struct FakeConversation final : Conversation {
  FakeConversation(ConversationCallbacks c, std::vector<std::string>& r, int& o, bool n)
      : calls(std::move(c)), received_frames(r), open(o), named(n) {
    ++open;
  }
  ~FakeConversation() override { --open; }
  void received(std::string_view text) override {
    received_frames.emplace_back(text);
    if (text == "echo") say("echoed");
    if (text == "leave") calls.close("as you like");
  }
  std::optional<std::string> next() override {
    if (!latest) return std::nullopt;
    ++asked;
    return std::exchange(latest, std::nullopt);
  }
  bool has_caller() const override { return named; }
  void say(std::string text) {
    latest = std::move(text);
    calls.wake();
  }

  ConversationCallbacks calls;
  std::vector<std::string>& received_frames;
  int& open;
  bool named;
  std::optional<std::string> latest;
  int asked = 0;
};

/// A site whose answers a test writes.
struct FakeSite final : Site {
  std::unique_ptr<Exchange> handle(const Request& request, Respond respond) override {
    requests.push_back(request);
    if (request.path == "/api/v1/never") return waiting(std::move(respond));
    if (request.path == "/api/v1/stream") {
      Response response{.content_type = "text/event-stream"};
      response.stream = [this](ConversationCallbacks calls) { return converse(std::move(calls)); };
      respond(std::move(response));
      return nullptr;
    }
    respond({.content_type = "text/plain", .body = request.method + " " + request.path});
    return nullptr;
  }
  bool takes_file(const Request& request) const override { return request.path == "/api/v1/upload"; }
  std::unique_ptr<Conversation> open(const Caller& caller, ConversationCallbacks calls) override {
    callers.push_back(caller);
    return converse(std::move(calls), caller.role != Role::kNone);
  }

  std::unique_ptr<Conversation> converse(ConversationCallbacks calls, bool named = true) {
    auto made = std::make_unique<FakeConversation>(std::move(calls), frames, conversations, named);
    conversation = made.get();
    return made;
  }
  std::unique_ptr<Exchange> waiting(Respond respond) {
    struct Waiting final : Exchange {
      Waiting(int& c) : count(c) { ++count; }
      ~Waiting() override { --count; }
      int& count;
    };
    late = std::move(respond);
    return std::make_unique<Waiting>(exchanges);
  }

  std::vector<Request> requests;
  std::vector<Caller> callers;
  std::vector<std::string> frames;
  FakeConversation* conversation = nullptr;  ///< the latest; dangling when `conversations` is 0
  int conversations = 0;
  int exchanges = 0;
  Respond late;
};

struct FakePage final : files::Page {
  std::optional<Response> find(const Request& request) const override {
    if (request.path != "/") return std::nullopt;
    return Response{.content_type = "text/html", .body = body};
  }

  std::string body = "<html>";
};

/// A server on a free port of loopback before a site of a test.
struct ServedTest : testing::Test {
  void serve(access::AccessRules rules = {}, ServerOptions options = {}) {
    server.reset();
    access.emplace(world.time, std::move(rules));
    if (options.listen.address.empty()) options.listen = {"127.0.0.1", 0};
    auto opened = Server::open({world.context, world.time, *access, site, page, Log(log, "web")}, std::move(options));
    ASSERT_TRUE(opened) << opened.error().text;
    server = std::move(*opened);
  }
  std::unique_ptr<RawClient> client(const std::string& source = {}) {
    return std::make_unique<RawClient>(world, server->local(), source);
  }
  WebWorld world;
  support::CollectingLog log;
  FakeSite site;
  FakePage page;
  std::optional<access::Access> access;
  std::unique_ptr<Server> server;
};

}  // namespace rubicon::web::server
