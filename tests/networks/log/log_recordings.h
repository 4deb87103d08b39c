#pragma once

#include <gmock/gmock.h>

#include "networks/log/log_support.h"
#include "recording/block_builder.h"
#include "recording/file_format.h"

namespace rubicon::networks::log {

using recording::Record;
using recording::RecordKind;

/// Writes recordings record by record; each call comes a second after the one before.
class Writer {
 public:
  void mark(std::string_view word) { add(RecordKind::kMark, "", word, "text/plain"); }
  void set(const std::string& key, std::string_view value, std::string_view media_type = "text/plain") {
    add(RecordKind::kSet, key, value, media_type);
  }
  void describe(const std::string& key, std::string_view json) { set(key, json, "application/json"); }
  void present(const std::string& key, std::string_view value) { add(RecordKind::kPresent, key, value, "text/plain"); }
  void erase(const std::string& key) { add(RecordKind::kDeleted, key, "", "text/plain"); }
  void add(RecordKind kind, const std::string& key, std::string_view value, std::string_view media_type) {
    if (!same_turn) now += 1s;
    const auto sequence = std::uint64_t{2} + count_++;
    block_.add({kind, now, owner, key, value, media_type, owner, sequence, now, user, {}});
    if (block_.full()) close();
  }
  void close() {
    const auto bytes = block_.close();
    blocks_.append(base::as_text(bytes));
  }
  std::string file() {
    if (!block_.empty()) close();
    const auto head = recording::encode_head({OwnerId(6541), prefix, now, "test"});
    return std::string(base::as_text(head)) + blocks_;
  }

  OwnerId owner{6541};
  std::string prefix = "proxy";
  WallTime now{std::chrono::seconds(1'700'000'000)};
  WallTime user{};
  bool same_turn = false;

 private:
  recording::BlockBuilder block_;
  std::string blocks_;
  std::uint64_t count_ = 0;
};

inline const std::string kLight =
    R"({"type":"light","type_id":1,"quantity":"x","unit":"lx","data_type":"real","access":"read","report":"state","instance":"1"})";
inline const std::string kMote =
    R"({"name":"Mote ä","model":"EM1000","type":"mote","address":"0x07","network":"wsn-1","capabilities":["light"],"sensors":["light-1"],"actuators":[],"properties":[]})";

class LogRecording : public testing::Test {
 protected:
  void join_mote(Writer& writer) {
    writer.same_turn = true;
    writer.set("proxy.wsn-1.7.sensor.light-1.value", "");
    writer.describe("proxy.wsn-1.7.sensor.light-1.description", kLight);
    writer.describe("proxy.wsn-1.7.description", kMote);
    writer.same_turn = false;
  }
  void play(const std::string& file, std::vector<std::pair<std::string, ConfigNode>> more = {}, Duration span = 1min) {
    listener_.files.files["home.rec"] = file;
    std::vector<std::pair<std::string, ConfigNode>> options{{"file", scalar("home.rec")}};
    options.insert(options.end(), more.begin(), more.end());
    made_ = make_log(listener_, map(std::move(options)), types_);
    ASSERT_NE(made_.network, nullptr) << (made_.errors.empty() ? "" : made_.errors.front());
    opened_ = made_.network->open();
    listener_.time.run_for(span);
  }
  std::vector<std::string> delivered() const {
    std::vector<std::string> out;
    for (const auto& reading : listener_.readings()) out.push_back(model::to_text(reading.value));
    return out;
  }
  /// What the line was, one after the other: `up`, `ended: why`.
  std::vector<std::string> lines() const {
    std::vector<std::string> out;
    for (const auto& [at, message] : listener_.of<model::State>()) {
      const auto& state = std::get<model::State>(message.body);
      auto line = std::string(to_string(state.line));
      if (state.line == model::LineState::kEnded || state.line == model::LineState::kDown) line += ": " + state.reason;
      if (out.empty() || out.back() != line) out.push_back(line);
    }
    return out;
  }
  std::vector<model::Join> joins() const {
    std::vector<model::Join> out;
    for (const auto& [at, message] : listener_.of<model::Join>()) out.push_back(std::get<model::Join>(message.body));
    return out;
  }

  TypeCatalogue types_;
  Listener listener_;
  Made made_;
  Result<void> opened_;
};

}  // namespace rubicon::networks::log
