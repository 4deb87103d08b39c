#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <sstream>

#include "base/virtual_scheduler.h"
#include "networks/log/log_network.h"

namespace rubicon::networks::log {

using namespace std::chrono_literals;

/// Configuration trees as C++ text: scalar("1"), map({{"speed", scalar("1")}}), list({...}).
inline ConfigNode scalar(std::string text) {
  ConfigNode node;
  node.kind = ConfigNode::Kind::kScalar;
  node.text = std::move(text);
  return node;
}
inline ConfigNode map(std::vector<std::pair<std::string, ConfigNode>> entries) {
  ConfigNode node;
  node.kind = ConfigNode::Kind::kMap;
  node.entries = std::move(entries);
  return node;
}
inline ConfigNode list(std::vector<std::string> texts) {
  ConfigNode node;
  node.kind = ConfigNode::Kind::kList;
  for (std::string& text : texts) node.items.push_back(scalar(std::move(text)));
  return node;
}
inline ConfigNode sensor(std::string point) {
  return map({{"sensor", scalar(std::move(point))}});
}

/// Files of memory, or of the disk where a path is not among them; counts how much a reader asked for at once.
class MemoryFiles final : public transport::Transports {
 public:
  Result<std::unique_ptr<transport::FileSource>> open_file(const std::string& path) override {
    ++opened;
    if (const auto found = files.find(path); found != files.end())
      return std::make_unique<Source>(found->second, *this);
    std::ifstream file(path, std::ios::binary);
    if (!file || std::filesystem::is_directory(path)) return fail(ErrorCode::kNotFound, path + ": no such file");
    std::ostringstream text;
    text << file.rdbuf();
    return std::make_unique<Source>(text.str(), *this);
  }

  std::map<std::string, std::string> files;
  std::size_t opened = 0;
  std::size_t largest_read = 0;
  bool broken = false;  ///< every read fails

 private:
  class Source final : public transport::FileSource {
   public:
    Source(std::string content, MemoryFiles& files) : content_(std::move(content)), files_(files) {}
    Result<std::size_t> read(std::span<std::uint8_t> into) override {
      if (files_.broken) return fail(ErrorCode::kIo, "the disk went away");
      files_.largest_read = std::max(files_.largest_read, into.size());
      const std::size_t count = std::min(into.size(), content_.size() - position_);
      std::copy_n(content_.begin() + static_cast<std::ptrdiff_t>(position_), count, into.begin());
      position_ += count;
      return count;
    }
    Result<void> seek(std::uint64_t offset) override {
      position_ = std::min<std::size_t>(offset, content_.size());
      return {};
    }
    std::uint64_t size() const override { return content_.size(); }

   private:
    std::string content_;
    MemoryFiles& files_;
    std::size_t position_ = 0;
  };
};

/// A host in virtual time that keeps what it hears, each message with its moment.
class Listener final : public network::NetworkHost, public base::LogSink {
 public:
  struct Heard {
    Duration at;
    Message message;
  };

  using NetworkHost::deliver;
  void deliver(Message&& message) override { heard.push_back({time.now() - start, std::move(message)}); }
  void failed(Error why) override { failures.push_back(why); }
  Scheduler& scheduler() override { return time; }
  transport::Transports& transports() override { return files; }
  const Log& log() const override { return log_; }
  void write(base::LogLevel, std::string_view, std::string_view text) override { lines.emplace_back(text); }

  /// The messages of one kind, in order.
  template <class Body>
  std::vector<std::pair<Duration, Message>> of() const {
    std::vector<std::pair<Duration, Message>> found;
    for (const Heard& one : heard) {
      if (std::holds_alternative<Body>(one.message.body)) found.emplace_back(one.at, one.message);
    }
    return found;
  }
  std::vector<model::Reading> readings() const {
    std::vector<model::Reading> all;
    for (const auto& [at, message] : of<model::Updates>()) {
      const auto& readings = std::get<model::Updates>(message.body).readings;
      all.insert(all.end(), readings.begin(), readings.end());
    }
    return all;
  }
  model::State last_state() const {
    const auto states = of<model::State>();
    return states.empty() ? model::State{} : std::get<model::State>(states.back().second.body);
  }
  std::uint64_t counter(const std::string& name) const { return last_state().counters.at(name); }

  VirtualScheduler time;
  MemoryFiles files;
  std::vector<Heard> heard;
  std::vector<Error> failures;
  std::vector<std::string> lines;

 private:
  SteadyTime start = time.now();
  Log log_{*this, "log-test"};
};

/// A LOG network made from options, or the errors that prevented it.
struct Made {
  std::unique_ptr<network::Network> network;
  std::vector<std::string> errors;
};

inline Made make_log(Listener& listener, ConfigNode options, const TypeCatalogue& types,
                     const std::string& directory = "") {
  ConfigErrors errors;
  ConfigReader reader(options, "networks.log-test", errors);
  const network::NetworkConfig config{"log-test", IslandId{1}, reader, types, directory};
  auto made = kType.make(config, listener);
  if (made) reader.finish();
  Made out;
  out.errors = errors.lines();
  if (made && out.errors.empty()) out.network = std::move(*made);
  return out;
}

inline std::string shared_data(const std::string& path) {
  return RUBICON_SOURCE_DIR "/../shared/data/" + path;
}

inline std::string bytes_of_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

}  // namespace rubicon::networks::log
