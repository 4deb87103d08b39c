#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "base/scheduler.h"
#include "base/text.h"
#include "base/virtual_scheduler.h"
#include "config/yaml.h"
#include "fuzz_target.h"
#include "island/island.h"
#include "island/network_types.h"
#include "model/point_keys.h"
#include "model/point_tuples.h"
#include "support/memory/memory_transports.h"
#include "tuples/memory/memory_ecology.h"
#include "web/api/api.h"
#include "web/server/http_text.h"

namespace rubicon::fuzz::web_api_fuzz {

namespace {

constexpr std::string_view kIslandOfWeb =
    "island: {id: 1}\nnetworks:\n  dummy: {type: dummy, simulate: {a: {sensors: {light-1: {}}, actuators: {lamp-1: "
    "{}}}}}\ndiscovery: {new-devices: ask}\n";

/// What a real island published within its first seconds.
struct Published {
  struct One {
    std::string key, value, media_type;
  };
  std::vector<One> tuples;
  std::string summary;

  /// Of the many counters one.
  static bool is_kept(std::string_view key) {
    return key.find(".property.") == key.npos || key.find(".line.") != key.npos || key.ends_with(".attempts.value");
  }

  Published() {
    VirtualScheduler time;
    transport::MemoryTransports files;
    base::NullLogSink log;
    tuples::MemoryEcology ecology{time};
    const auto tree = config::parse_yaml(kIslandOfWeb, "island.yaml");
    base::ConfigErrors errors;
    auto config = island::read_island_config(tree.value(), island::network_types(), errors);
    const auto island = island::Island::make(std::move(config), time, files, log, ecology, errors).value();
    const auto link = ecology.join(OwnerId(65536)).value();
    TupleSpace space{OwnerId(65536), time, *link};
    const auto all = space.subscribe({OwnerId(1), "**"}, {.passive = true}, [](const tuples::Event&) {});
    island->start();
    time.run_for(std::chrono::seconds(5));
    space.list({OwnerId(1), "**"}, [this](const tuples::TupleView& one) {
      if (is_kept(one.key))
        tuples.push_back({std::string(one.key), std::string(one.value), std::string(one.media_type)});
    });
    summary = space.summary(OwnerId(1));
  }
};

/// Owns the tuples of a real island, and confirms each command. A real one takes as long to start as hundreds of
/// requests.
class PlayedIsland {
 public:
  PlayedIsland(VirtualScheduler& time, tuples::MemoryEcology& ecology)
      : time_(time), link_(ecology.join(OwnerId(1)).value()), space_(OwnerId(1), time, *link_) {
    for (const auto& one : published().tuples) set(one);
    std::ignore = space_.describe(published().summary);
    policy_ = space_.add_policy(
        {OwnerId(1), "**"}, [this](const tuples::RemoteSet& set) { return decide(set); },
        tuples::PolicyScope::kSetsAndAppends);
  }

  /// As if nothing had been set.
  void restore() {
    if (!std::exchange(is_changed_, false)) return;
    space_.erase(Pattern{OwnerId(1), "**"});
    for (const auto& one : published().tuples) set(one);
  }

 private:
  static const Published& published() {
    static const Published kPublished;
    return kPublished;
  }
  void set(const Published::One& one) { std::ignore = space_.set(one.key, one.value, {one.media_type, {}, {}}); }

  tuples::SetDecision decide(const tuples::RemoteSet& set) {
    is_changed_ = true;
    if (set.value.empty()) return tuples::SetDecision::refused({ErrorCode::kInvalid, "empty"});
    const std::string key(set.key);
    if (key.ends_with(".command")) {
      model::CommandStatus status{"confirmed", {set.from, "", set.request}, std::string(set.value), {}, {}, {}, {}};
      lifetime_.post(time_, [this, key, text = model::command_status_to_json(status)] {
        const auto point = std::string(model::parent_key(key));
        std::ignore = space_.set(model::PointKey{point}.status(), "{\"command\":" + text + "}");
      });
    }
    return tuples::SetDecision::applied();
  }

  VirtualScheduler& time_;
  std::unique_ptr<tuples::Link> link_;
  TupleSpace space_;
  tuples::Handle policy_;
  bool is_changed_ = false;
  base::Lifetime lifetime_;
};

void must(bool holds) {
  if (!holds) __builtin_trap();
}

/// Every frame is one JSON object.
void take_frames(web::Conversation& conversation) {
  while (const auto frame = conversation.next()) must(nlohmann::json::parse(*frame, nullptr, false).is_object());
}

std::string_view take_word(std::string_view& line) {
  const auto end = line.find(' ');
  const auto word = line.substr(0, end);
  line.remove_prefix(end == line.npos ? line.size() : end + 1);
  return word;
}

/// `PUT /api/v1/tuples/1/a text/plain on`: method, target, Accept or -, body.
std::optional<web::Request> request_of(std::string_view line) {
  web::Request request;
  request.method = take_word(line);
  auto target = web::server::parse_target(take_word(line));
  if (!target) return std::nullopt;
  request.path = std::move(target->path);
  request.query = std::move(target->query);
  request.headers.emplace_back("accept", take_word(line));
  request.body = line;
  request.caller = {"local", web::Role::kAdmin, "::1"};
  return request;
}

/// The API beside an island.
struct World {
  VirtualScheduler time;
  base::NullLogSink log;
  tuples::MemoryEcology ecology{time};
  PlayedIsland island{time, ecology};
  std::unique_ptr<tuples::Link> link = ecology.join(OwnerId(65536)).value();
  TupleSpace space{OwnerId(65536), time, *link};
  web::access::Access access{time, {}};
  web::api::Api api{time, space, log, access};
};

/// What one input asks for.
class Visit {
 public:
  explicit Visit(World& world)
      : world_(world), socket_(world.api.open({"local", web::Role::kAdmin, "::1"}, {[] {}, [](std::string_view) {}})) {}

  void line(std::string_view text) {
    if (text.starts_with('{') || text.starts_with('[')) {
      if (base::is_utf8(text)) socket_->received(text);
      if (!is_deaf_) take_frames(*socket_);
    } else if (text == "deaf") {
      is_deaf_ = !is_deaf_;
    } else if (const auto request = request_of(text)) {
      ask(*request);
    }
  }

  void finish() {
    for (int i = 0; i < 4; ++i) {
      world_.time.run_for(std::chrono::milliseconds(500));
      take_frames(*socket_);
      for (const auto& stream : streams_) {
        while (stream->next()) {
        }
      }
    }
    streams_.clear();  // they would go on during the wait
    socket_.reset();
    const auto is_open = [](int count) { return count == 0; };
    for (int i = 0; i < 700 && std::any_of(answers_.begin(), answers_.end(), is_open); ++i)  // the longest wait: 600 s
      world_.time.run_for(std::chrono::seconds(1));
    for (const auto count : answers_) must(count == 1);
  }

 private:
  void ask(const web::Request& request) {
    const auto number = answers_.size();
    answers_.push_back(0);
    exchanges_.push_back(world_.api.handle(request, [this, number](web::Response response) {
      must(++answers_[number] == 1);
      must(response.status >= 200 && response.status < 600);
      if (response.content_type == "application/json")
        must(nlohmann::json::parse(response.body, nullptr, false).is_object());
      if (response.stream) streams_.push_back(response.stream({[] {}, [](std::string_view) {}}));
    }));
  }

  World& world_;
  std::unique_ptr<web::Conversation> socket_;
  bool is_deaf_ = false;
  std::vector<int> answers_;
  std::vector<std::unique_ptr<web::Exchange>> exchanges_;
  std::vector<std::unique_ptr<web::Conversation>> streams_;
};

/// One for many inputs, because it takes as long to make as some of them; each ends all that it began.
World& world() {
  constexpr unsigned kInputs = 256;
  static std::unique_ptr<World> now;
  static unsigned used = 0;
  if (used++ % kInputs == 0) {
    now.reset();
    now = std::make_unique<World>();
    now->time.run_for(std::chrono::milliseconds(10));
  }
  return *now;
}

/// Inputs are being tried.
bool is_fuzzing = false;

}  // namespace

/// The world that inputs share allocates more than it frees in many of them, and libFuzzer would look for leaks after
/// each (100 ms). They are looked for at the end.
extern "C" int __lsan_is_turned_off() {
  return is_fuzzing ? 1 : 0;
}

static void look_for_leaks_at_the_end() {
  is_fuzzing = true;
  std::ignore = std::atexit([] { is_fuzzing = false; });
}

/// Frames of a WebSocket and requests by HTTP, a line each, to the API beside the tuples of an island; time passes
/// between them.
FUZZ_TARGET(web_api, look_for_leaks_at_the_end) {
  if (size > 16384) return 0;
  World& there = world();
  {
    Visit visit(there);
    std::string_view rest(reinterpret_cast<const char*>(data), size);
    while (!rest.empty()) {
      const auto end = rest.find('\n');
      visit.line(rest.substr(0, end));
      there.time.run_for(std::chrono::milliseconds(20));
      rest.remove_prefix(end == rest.npos ? rest.size() : end + 1);
    }
    visit.finish();
  }
  there.island.restore();
  there.time.run_for(std::chrono::seconds(1));
  return 0;
}

}  // namespace rubicon::fuzz::web_api_fuzz
