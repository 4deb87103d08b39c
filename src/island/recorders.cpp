#include "island/recorders.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/own_file.h"
#include "base/text.h"
#include "model/json_members.h"
#include "rubicon/key.hpp"

namespace rubicon::island {

namespace {

constexpr std::string_view kMark = "mark";

/// The text behind `mark`; nullopt for what is not a mark.
std::optional<std::string_view> mark_in(std::string_view command) {
  if (!command.starts_with(kMark)) return std::nullopt;
  command.remove_prefix(kMark.size());
  if (!command.empty() && command.front() != ' ') return std::nullopt;
  return base::trimmed(command);
}

}  // namespace

RecorderSwitch::RecorderSwitch(config::RecorderSetup setup, const recorder::Recorder::Context& context,
                               const proxy::ProxyConfig& config)
    : setup_(std::move(setup)),
      context_(context),
      command_({context_.scheduler, context_.space, config}, model::IslandKey{context_.prefix}.recorder(setup_.name),
               {[this](const std::string& text) { return check(text); },
                [this](const std::string& text) { return run(text); }, [this] { return status(); }}) {
  start();
  show();
}

recorder::Recorder::Counters RecorderSwitch::counters() const {
  auto sum = before_;
  if (!recorder_) return sum;
  const auto& now = recorder_->counters();
  sum.records += now.records;
  sum.bytes += now.bytes;
  sum.dropped += now.dropped;
  sum.files += now.files;
  sum.failures += now.failures;
  sum.cut += now.cut;
  return sum;
}

Result<void> RecorderSwitch::check(const std::string& text) const {
  if (text == "start" || text == "stop" || mark_in(text)) return {};
  return fail(ErrorCode::kInvalid, fmt::format("{}, expected `start`, `stop` or `mark TEXT`", model::quoted(text)));
}

Result<void> RecorderSwitch::run(const std::string& text) {
  if (const auto mark = mark_in(text)) {
    if (!recorder_) return fail(ErrorCode::kRefused, fmt::format("recorder {} is stopped", setup_.name));
    return recorder_->note(*mark);
  }
  if (text == "stop") {
    stop();
    return {};
  }
  start();
  if (recorder_->reason().empty()) return {};
  return fail(ErrorCode::kIo, fmt::format("{}; it is tried again", recorder_->reason()));
}

void RecorderSwitch::start() {
  if (recorder_) return;
  recorder_ = std::make_unique<recorder::Recorder>(setup_, context_);
  recorder_->start();
}

void RecorderSwitch::stop() {
  if (!recorder_) return;
  recorder_->flush();
  size_ = recorder_->file_size();
  before_ = counters();
  const auto path = recorder_->path();
  recorder_.reset();
  base::Log(context_.log, "recorder " + setup_.name).info(fmt::format("{}: stopped by a user", path));
}

nlohmann::ordered_json RecorderSwitch::status() {
  const auto* word = !recorder_ ? "stopped" : recorder_->reason().empty() ? "recording" : "dropping";
  if (std::exchange(word_, word) != word) since_ = context_.scheduler.wall_now();
  if (recorder_ && recorder_->file_size() > 0) size_ = recorder_->file_size();
  const auto sums = counters();
  return {{"state", word},
          {"reason", recorder_ ? recorder_->reason() : std::string()},
          {"file", base::whole_path(base::resolve_path(context_.directory, setup_.file))},
          {"size", size_},
          {"records", sums.records},
          {"dropped", sums.dropped},
          {"failures", sums.failures},
          {"since", model::seconds_json(since_)}};
}

void Recorders::take(const std::vector<config::RecorderSetup>& setups, const std::string& directory) {
  const bool moved = directory != context_.directory;
  context_.directory = directory;
  // All that end first: two recorders may swap their files.
  std::erase_if(all_, [&](const auto& recorder) {
    return moved || std::find(setups.begin(), setups.end(), recorder->setup()) == setups.end();
  });
  for (const auto& setup : setups) {
    const bool runs =
        std::any_of(all_.begin(), all_.end(), [&](const auto& recorder) { return recorder->setup() == setup; });
    if (!runs) all_.push_back(std::make_unique<RecorderSwitch>(setup, context_, config_));
  }
}

void Recorders::publish_counters(const IslandMetrics::Publish& publish) const {
  for (const auto& recorder : all_) {
    const auto prefix = "recorder-" + recorder->setup().name + "-";
    const auto counters = recorder->counters();
    publish.word(prefix + "state", recorder->state());
    publish(prefix + "records", counters.records);
    publish(prefix + "bytes", counters.bytes);
    publish(prefix + "dropped", counters.dropped);
    publish(prefix + "files", counters.files);
    publish(prefix + "failures", counters.failures);
    publish(prefix + "cut", counters.cut);
  }
}

void Recorders::show() const {
  for (const auto& recorder : all_) recorder->show();
}

void Recorders::each(const std::function<void(const std::string& name, const std::string& path)>& visit) const {
  for (const auto& recorder : all_)
    visit(recorder->setup().name, base::resolve_path(context_.directory, recorder->setup().file));
}

}  // namespace rubicon::island
