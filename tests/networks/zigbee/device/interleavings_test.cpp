#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <set>

#include "device_support.h"

namespace rubicon::networks::zigbee {
namespace {

using nlohmann::json;

constexpr std::string_view kDefinition = R"([
  {"type":"numeric","name":"wish","property":"wish","access":ACCESS,"value_min":0,"value_max":1000000000},
  {"type":"numeric","name":"goal","property":"goal","access":ACCESS,"value_min":0,"value_max":1000000000},
  {"type":"numeric","name":"power","property":"power","access":1,"unit":"W"}])";

bridge::DeviceRecord record_with(int access, bool battery) {
  std::string definition(kDefinition);
  for (std::size_t at; (at = definition.find("ACCESS")) != definition.npos;)
    definition.replace(at, 6, std::to_string(access));
  return record_of(definition, battery);
}

/// What a device does with a set.
enum class Manner : std::uint8_t { kObeys, kIgnores, kDead, kRejected };

/// Zigbee2MQTT with one device that obeys, ignores or is dead by chance; every commanded value is another one, so that
/// the test knows which of them the device ever had.
class World {
 public:
  World(unsigned seed, int access, bool battery, bool obeys_always)
      : random_(seed), record_(record_with(access, battery)), obeys_always_(obeys_always) {
    host_.on_publish = [this](const FakeDeviceHost::Publication& one) { on_publish(one); };
    device_ = std::make_unique<Device>(host_, models_, record_);
    device_->line_up();
    for (const auto* key : {"wish", "goal"}) {
      cached_[key] = truth_[key] = 1;
      had_.insert(1);
    }
    cached_["power"] = 5;
  }

  void run(int steps) {
    for (int i = 0; i < steps; ++i) {
      step();
      host_.time.run_for(milliseconds(chance(50) ? number(30) : number(1500)));
      notice();
    }
    host_.time.run_for(seconds(40));
    notice();
  }

  void check() const {
    std::map<std::uint64_t, int> answers;
    for (const auto& [request, late] : answered_) {
      ++answers[request];
      EXPECT_LE(late, zigbee::device::Commands::kAnswerTime);
    }
    for (const auto& [request, at] : requests_) EXPECT_EQ(answers[request], 1) << "request " << request;
    EXPECT_EQ(answers.size(), requests_.size());
    for (const auto& [value, times] : published_) EXPECT_EQ(times, 1) << value << " was published again";
    EXPECT_EQ(without_line_, 0U);
    EXPECT_TRUE(record_.mains() || host_.payloads("get").empty());
    for (const auto value : shown_) EXPECT_TRUE(had_.contains(value)) << "the device never had " << value;
  }
  std::size_t shown() const { return shown_.size(); }

 private:
  int number(int below) { return static_cast<int>(random_() % static_cast<unsigned>(below)); }
  bool chance(int percent) { return number(100) < percent; }
  std::string any_key() { return chance(60) ? "wish" : "goal"; }

  void step() {
    switch (number(10)) {
      case 0:
      case 1:
      case 2: return command();
      case 3: return spontaneous();
      case 4: return host_.time.now() > asked_at_ + seconds(1) ? say(true) : void();  // see Verification
      case 5: cached_["power"] = number(100); return say(true);
      case 6: return say(false);
      case 7: return chance(20) ? toggle_line() : void();
      default: return;
    }
  }
  void command() {
    const auto key = any_key();
    Message message;
    const auto id = ++last_request_;
    for (const auto& point : device_->points()) {
      if (point.property == key)
        message.body = model::Actuate{id, point.capability.point, Value(static_cast<double>(1000 + 10 * id)),
                                      chance(50) ? milliseconds(0) : milliseconds(1 + number(10'000))};
    }
    requests_[id] = host_.time.now();
    if (!device_->send(message)) answered_.emplace_back(id, Duration(0));
  }
  void spontaneous() {
    if (dead_) return;
    const auto key = any_key();
    cached_[key] = truth_[key] = 1'000'000 + number(1'000'000);
    had_.insert(truth_[key]);
    say(true);
  }
  void toggle_line() {
    up_ = !up_;
    up_ ? device_->line_up() : device_->line_lost("gone");
  }
  /// `later`: the device was heard.
  void say(bool later) {
    if (!up_) return;
    if (later) seen_ = std::max(host_.time.wall_now(), seen_ + milliseconds(1));
    json message = cached_;
    message["last_seen"] = iso(seen_);
    EXPECT_TRUE(device_->state(message.dump(), false));
  }
  void later(Duration delay, std::function<void()> call) {
    timers_.push_back(host_.time.after(delay, std::move(call)));
  }

  void on_publish(const FakeDeviceHost::Publication& one) {
    if (!up_) ++without_line_;
    const auto payload = json::parse(one.payload);
    one.verb == "set" ? on_set(payload) : on_get(payload);
  }
  /// What was delivered since the last time.
  void notice() {
    for (; heard_ < host_.delivered.size(); ++heard_) {
      if (const auto* answer = std::get_if<model::Acknowledge>(&host_.delivered[heard_]))
        answered_.emplace_back(answer->request, host_.delivered_at[heard_] - requests_.at(answer->request));
      if (const auto* updates = std::get_if<model::Updates>(&host_.delivered[heard_])) note(*updates);
    }
  }
  void note(const model::Updates& updates) {
    for (const auto& reading : updates.readings) {
      for (const auto& point : device_->points()) {
        const bool settable = point.capability.point == reading.point && point.access.settable;
        if (settable) shown_.push_back(static_cast<std::int64_t>(std::get<double>(reading.value)));
      }
    }
  }
  void on_set(const json& payload) {
    const auto manner = obeys_always_ ? Manner::kObeys : static_cast<Manner>(number(4));
    for (const auto& [key, value] : payload.items()) ++published_[value.get<std::int64_t>()];
    if (manner == Manner::kDead || manner == Manner::kRejected) return;
    const bool heard_first = chance(70);
    const auto heard = [this] { say(true); };
    const auto echo = [this, payload] {
      for (const auto& [key, value] : payload.items()) cached_[key] = value;
      say(false);
    };
    if (heard_first) later(milliseconds(8), heard);
    later(milliseconds(9), echo);
    if (!heard_first) later(milliseconds(10), heard);
    if (manner == Manner::kObeys) later(milliseconds(11 + number(200)), [this, payload] { obey(payload); });
  }
  void obey(const json& payload) {
    for (const auto& [key, value] : payload.items()) {
      cached_[key] = truth_[key] = value.get<std::int64_t>();
      had_.insert(truth_[key]);
    }
    if (chance(70)) say(true);
  }
  void on_get(const json& payload) {
    asked_at_ = host_.time.now();
    if (chance(20)) return;
    later(milliseconds(1 + number(60)), [this, payload] {
      for (const auto& [key, value] : payload.items()) {
        if (truth_.contains(key)) cached_[key] = truth_[key];
      }
      say(true);
    });
  }

  std::mt19937 random_;
  TypeCatalogue types_;
  exposes::PointsOfModels models_{types_};
  FakeDeviceHost host_;
  bridge::DeviceRecord record_;
  bool obeys_always_ = false, dead_ = false, up_ = true;
  std::unique_ptr<Device> device_;
  std::map<std::string, std::int64_t> cached_, truth_;
  std::set<std::int64_t> had_;
  std::vector<std::int64_t> shown_;
  WallTime seen_{};
  std::map<std::uint64_t, SteadyTime> requests_;
  std::vector<std::pair<std::uint64_t, Duration>> answered_;
  std::map<std::int64_t, int> published_;
  std::size_t heard_ = 0, without_line_ = 0;
  std::uint64_t last_request_ = 0;
  SteadyTime asked_at_{};
  std::vector<Timer> timers_;
};

TEST(Interleavings, ADeviceThatCanBeAskedIsNeverShownWithAValueThatItNeverHad) {
  std::size_t shown = 0;
  for (unsigned seed = 0; seed < 200 && !testing::Test::HasFailure(); ++seed) {
    SCOPED_TRACE(seed);
    World world(seed, 7, false, false);
    world.run(150);
    world.check();
    shown += world.shown();
  }
  EXPECT_GT(shown, 3000U);
}

TEST(Interleavings, ADeviceThatCannotBeAskedIsShownWithWhatItReported) {
  for (const bool battery : {false, true}) {
    for (unsigned seed = 0; seed < 200 && !testing::Test::HasFailure(); ++seed) {
      SCOPED_TRACE(seed);
      World world(seed, battery ? 7 : 3, battery, true);
      world.run(150);
      world.check();
    }
  }
}

}  // namespace
}  // namespace rubicon::networks::zigbee
