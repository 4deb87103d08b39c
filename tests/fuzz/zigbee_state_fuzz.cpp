#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <set>

#include "base/text.h"
#include "base/virtual_scheduler.h"
#include "fuzz_target.h"
#include "networks/zigbee/device.h"

namespace rubicon::fuzz::zigbee_state_fuzz {

namespace {

using namespace rubicon::networks::zigbee;

constexpr std::string_view kDefinition = R"([
  {"type":"light","features":[
    {"type":"binary","name":"state","property":"state","access":7,"value_on":"ON","value_off":"OFF"},
    {"type":"numeric","name":"brightness","property":"brightness","access":7,"value_min":0,"value_max":254},
    {"type":"numeric","name":"color_temp","property":"color_temp","access":7,"unit":"mired","value_min":153,
     "value_max":500,"presets":[{"name":"coolest","value":153},{"name":"previous","value":"previous"}]},
    {"type":"composite","name":"color_xy","property":"color","access":7,"features":[
      {"type":"numeric","name":"x","property":"x","access":7},{"type":"numeric","name":"y","property":"y","access":7}]},
    {"type":"composite","name":"color_hs","property":"color","access":7,"features":[
      {"type":"numeric","name":"hue","property":"hue","access":7},
      {"type":"numeric","name":"saturation","property":"saturation","access":7}]}]},
  {"type":"cover","features":[
    {"type":"enum","name":"state","property":"state_left","access":3,"values":["OPEN","CLOSE","STOP"]},
    {"type":"numeric","name":"position","property":"position","access":7,"unit":"%","value_min":0,"value_max":100}]},
  {"type":"numeric","name":"temperature","property":"temperature","access":5,"unit":"°C"},
  {"type":"binary","name":"contact","property":"contact","access":1,"value_on":false,"value_off":true},
  {"type":"enum","name":"action","property":"action","access":1,"values":["single","double"]},
  {"type":"text","name":"code","property":"code","access":3},
  {"type":"list","name":"days","property":"days","access":3,"item_type":{"type":"numeric","name":"day","access":3}},
  {"type":"composite","name":"plan","property":"plan","access":3,"features":[
    {"type":"text","name":"when","property":"when","access":3}]}])";

/// Values of tuples are finite numbers and shallow JSON, whatever a device publishes.
void expect_good(const Value& value) {
  if (const auto* real = std::get_if<double>(&value); real && !std::isfinite(*real)) std::abort();
  const auto* tree = std::get_if<Json>(&value);
  if (tree && (base::is_nested_deeper(tree->text, exposes::kDeepestJson) || !nlohmann::json::accept(tree->text)))
    std::abort();
}

class Host final : public DeviceHost {
 public:
  Result<void> publish(const std::string&, std::string_view, std::string) override {
    if (!up) std::abort();
    return {};
  }
  void deliver(const std::string&, model::Body body) override {
    const auto* answer = std::get_if<model::Acknowledge>(&body);
    if (answer && !answered.insert(answer->request).second) std::abort();
    if (const auto* updates = std::get_if<model::Updates>(&body)) {
      for (const auto& reading : updates->readings) expect_good(reading.value);
    }
  }
  Scheduler& scheduler() override { return time; }
  bool take_poll(const std::string&) override { return true; }

  VirtualScheduler time;
  std::set<std::uint64_t> answered;
  bool up = true;
};

/// `!P VALUE`: a command for the point of this letter; `-`, `+`: the line; `?`: a demand; else a state message.
class Story {
 public:
  explicit Story(bool battery) : device_(host_, models(), record(battery)) { device_.line_up(); }

  void step(std::string_view line) {
    host_.time.run_for(std::chrono::milliseconds(50 + line.size()));
    if (line.starts_with('!') && line.size() > 2) return command(line.substr(1));
    if (line == "?") return demand();
    if (line == "-" || line == "+") return set_line(line == "+");
    const auto done = device_.state(line, false);
    if (!done && done.error().text.empty()) std::abort();
  }
  void end() {
    host_.time.run_for(std::chrono::seconds(30));
    if (host_.answered.size() != sent_.size()) std::abort();
  }

 private:
  /// Takes longer to make than most stories to run.
  static const TypeCatalogue& types() {
    static const TypeCatalogue all;
    return all;
  }
  static exposes::PointsOfModels& models() {
    static exposes::PointsOfModels of_all(types());
    return of_all;
  }
  static bridge::DeviceRecord record(bool battery) {
    static const auto leaves = [] {
      std::vector<std::string> skipped;
      return exposes::read_exposes(kDefinition, skipped).value();
    }();
    bridge::DeviceRecord record;
    record.address = "00124b0010000000";
    record.name = "one";
    record.power_source = battery ? "Battery" : "Mains (single phase)";
    record.leaves = leaves;
    return record;
  }
  void command(std::string_view text) {
    const auto& points = device_.points();
    const auto& point = points[static_cast<unsigned char>(text[0]) % points.size()];
    const auto value = exposes::decode(point, text.substr(1));
    if (!value) return;
    Message message;
    message.body = model::Actuate{++request_, point.capability.point, *value, std::chrono::seconds(5)};
    if (device_.send(message)) sent_.insert(request_);
  }
  void demand() {
    model::Sample sample{++request_, {}, std::chrono::seconds(2)};
    for (const auto& point : device_.points()) sample.points.push_back(point.capability.point);
    Message message;
    message.body = std::move(sample);
    if (device_.send(message)) sent_.insert(request_);
  }
  void set_line(bool up) {
    if (host_.up == up) return;
    host_.up = up;
    up ? device_.line_up() : device_.line_lost("gone");
  }

  Host host_;
  Device device_;
  std::uint64_t request_ = 0;
  std::set<std::uint64_t> sent_;
};

}  // namespace

/// Input: `b` for a battery or anything else; then what happens to a device, a line each.
FUZZ_TARGET(zigbee_state) {
  if (size == 0) return 0;
  std::string_view text(reinterpret_cast<const char*>(data), size);
  Story story(text[0] == 'b');
  text.remove_prefix(1);
  for (std::size_t lines = 0; !text.empty() && lines < 50; ++lines) {
    const auto end = std::min(text.find('\n'), text.size());
    story.step(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  story.end();
  return 0;
}

}  // namespace rubicon::fuzz::zigbee_state_fuzz
