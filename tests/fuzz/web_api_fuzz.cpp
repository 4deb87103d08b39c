#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/printable.h"
#include "base/virtual_scheduler.h"
#include "config/yaml.h"
#include "island/island.h"
#include "island/network_types.h"
#include "transport/memory/memory_transports.h"
#include "tuples/memory/memory_ecology.h"
#include "web/api/api.h"
#include "web/server/target.h"

namespace {

using namespace rubicon;

constexpr std::string_view kIslandOfWeb =
    "island: {id: 1}\nnetworks:\n  dummy: {type: dummy, simulate: {a: {sensors: {light-1: {}}, actuators: {lamp-1: "
    "{}}}}}\ndiscovery: {new-devices: ask}\n";

std::unique_ptr<island::Island> make_web_island(VirtualScheduler& time, transport::MemoryTransports& files,
                                                base::LogSink& log, tuples::MemoryEcology& ecology) {
  static const auto tree = config::parse_yaml(kIslandOfWeb, "island.yaml");
  base::ConfigErrors errors;
  auto config = island::read_island_config(tree.value(), island::network_types(), errors);
  return std::move(island::Island::make(std::move(config), time, files, log, ecology, errors).value());
}

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

struct World {
  World() { island->start(); }

  void line(std::string_view text) {
    if (text.starts_with('{') || text.starts_with('[')) {
      if (base::is_utf8(text)) socket->received(text);
      if (!is_deaf) take_frames(*socket);
    } else if (text == "deaf") {
      is_deaf = !is_deaf;
    } else if (const auto request = request_of(text)) {
      ask(*request);
    }
  }

  void ask(const web::Request& request) {
    const auto number = asked++;
    answers.push_back(0);
    exchanges.push_back(api.handle(request, [this, number](web::Response response) {
      must(++answers[number] == 1);
      must(response.status >= 200 && response.status < 600);
      if (response.content_type == "application/json")
        must(nlohmann::json::parse(response.body, nullptr, false).is_object());
      if (response.stream) streams.push_back(response.stream({[] {}, [](std::string_view) {}}));
    }));
  }

  void finish() {
    for (int i = 0; i < 10; ++i) {
      time.run_for(std::chrono::milliseconds(500));
      take_frames(*socket);
      for (const auto& stream : streams) {
        while (stream->next()) {
        }
      }
    }
    const auto is_open = [](int count) { return count == 0; };
    for (int i = 0; i < 700 && std::any_of(answers.begin(), answers.end(), is_open); ++i)  // the longest wait: 600 s
      time.run_for(std::chrono::seconds(1));
    for (const auto count : answers) must(count == 1);
  }

  VirtualScheduler time;
  transport::MemoryTransports files;
  base::NullLogSink log;
  tuples::MemoryEcology ecology{time};
  std::unique_ptr<island::Island> island = make_web_island(time, files, log, ecology);
  std::unique_ptr<tuples::Link> link = ecology.join(OwnerId(65536)).value();
  TupleSpace space{OwnerId(65536), time, *link};
  web::access::Access access{time, {}};
  web::api::Api api{time, space, log, access};
  std::unique_ptr<web::Conversation> socket =
      api.open({"local", web::Role::kAdmin, "::1"}, {[] {}, [](std::string_view) {}});
  bool is_deaf = false;
  std::size_t asked = 0;
  std::vector<int> answers;
  std::vector<std::unique_ptr<web::Exchange>> exchanges;
  std::vector<std::unique_ptr<web::Conversation>> streams;
};

}  // namespace

/// Frames of a WebSocket and requests by HTTP, a line each, to the API beside a living island; time passes between
/// them.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  if (size > 16384) return 0;
  World world;
  world.time.run_for(std::chrono::milliseconds(10));
  std::string_view rest(reinterpret_cast<const char*>(bytes), size);
  while (!rest.empty()) {
    const auto end = rest.find('\n');
    world.line(rest.substr(0, end));
    world.time.run_for(std::chrono::milliseconds(20));
    rest.remove_prefix(end == rest.npos ? rest.size() : end + 1);
  }
  world.finish();
  return 0;
}
