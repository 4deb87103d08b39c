#include "apps/simulators/zigbee/replay.h"

#include <fmt/format.h>

#include <cmath>

#include "base/text.h"
#include "model/json_members.h"

namespace rubicon::zigbee_simulator {

namespace {

using namespace std::chrono_literals;

constexpr Duration kRetryPause = 1s;
/// While the queue of the line is full.
constexpr Duration kBusyPause = 5ms;

/// Seconds since 1970 of `2026-11-21T00:16:31.822421Z...`; nullopt for another form.
std::optional<Duration> time_of_text(std::string_view text) {
  if (text.size() < 20 || text[10] != 'T') return std::nullopt;
  const auto year = base::parse_number<int>(text.substr(0, 4));
  const auto month = base::parse_number<unsigned>(text.substr(5, 2));
  const auto day = base::parse_number<unsigned>(text.substr(8, 2));
  const auto hours = base::parse_number<int>(text.substr(11, 2));
  const auto minutes = base::parse_number<int>(text.substr(14, 2));
  const auto zone = text.find_first_of("Z+", 17);
  const auto seconds = base::parse_number<double>(text.substr(17, zone == text.npos ? text.npos : zone - 17));
  if (!year || !month || !day || !hours || !minutes || !seconds || !std::isfinite(*seconds)) return std::nullopt;
  const std::chrono::year_month_day date{std::chrono::year(*year), std::chrono::month(*month), std::chrono::day(*day)};
  if (!date.ok() || *year < 1970 || *year > 2200) return std::nullopt;
  return std::chrono::sys_days(date).time_since_epoch() + std::chrono::hours(*hours) + std::chrono::minutes(*minutes) +
         std::chrono::microseconds(std::llround(*seconds * 1e6));
}

bool is_of_client(std::string_view topic) {
  return topic.starts_with("bridge/request/") || topic.ends_with("/set") || topic.ends_with("/get");
}

bool is_retained(std::string_view topic) {
  return topic.ends_with("/availability") ||
         (topic.starts_with("bridge/") && topic != "bridge/event" && !topic.starts_with("bridge/response/"));
}

}  // namespace

Result<std::vector<RecordedMessage>> read_trace(std::string_view text) {
  std::vector<RecordedMessage> all;
  Duration first{};
  for (int number = 1; !text.empty(); ++number) {
    const auto end = std::min(text.find('\n'), text.size());
    const auto line = base::trimmed(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.empty()) continue;
    const auto entry = model::object_of(line);
    const auto at = time_of_text(model::text_of(entry, "tst"));
    const auto topic = model::text_of(entry, "topic");
    const auto slash = topic.find('/');
    const auto payload = entry.find("payload");
    if (!at || slash == topic.npos || payload == entry.end())
      return fail(ErrorCode::kInvalid,
                  fmt::format("line {}: expected a JSON object with tst, topic and payload", number));
    if (all.empty() && first == Duration{}) first = *at;
    if (is_of_client(std::string_view(topic).substr(slash + 1))) continue;
    all.push_back({std::max(*at - first, Duration{}), topic.substr(slash + 1),
                   payload->is_string() ? payload->get<std::string>() : model::dump(*payload)});
  }
  return all;
}

Replay::Replay(Options options, std::vector<RecordedMessage> messages, Scheduler& scheduler,
               transport::Transports& transports, Log log, std::function<void(Result<void>)> done)
    : options_(std::move(options)),
      messages_(std::move(messages)),
      scheduler_(scheduler),
      transports_(transports),
      log_(std::move(log)),
      done_(std::move(done)) {
  options_.broker.will = transport::MqttWill{options_.base + "/bridge/state", R"({"state":"offline"})", true};
}

Result<void> Replay::open() {
  transport::MqttCallbacks calls;
  calls.connected = [this](const transport::MqttConnack&) {
    connected_ = true;
    began_ = scheduler_.now();
    if (started) started();
    resume();
  };
  calls.failed = [this](const Error& why) { failed(why); };
  auto opened = transports_.open_mqtt(options_.broker, std::move(calls));
  if (!opened) return fail(opened.error());
  line_ = std::move(*opened);
  return {};
}

void Replay::failed(const Error& why) {
  line_.reset();
  timer_.cancel();
  if (connected_) return done_(fail(why));
  log_.error(why.text);
  timer_ = scheduler_.after(kRetryPause, [this] {
    if (const auto opened = open(); !opened) failed(opened.error());
  });
}

void Replay::resume() {
  while (next_ < messages_.size()) {
    const auto& message = messages_[next_];
    const auto at = options_.speed > 0 ? due_time(message.at) : began_;
    if (at > scheduler_.now()) {
      timer_ = scheduler_.at(at, [this] { resume(); });
      return;
    }
    if (!send(message)) {
      timer_ = scheduler_.after(kBusyPause, [this] { resume(); });
      return;
    }
    ++next_;
  }
  line_.reset();  // sends what waits
  done_({});
}

SteadyTime Replay::due_time(Duration at) const {
  return began_ + std::chrono::duration_cast<Duration>(
                      std::chrono::duration<double, std::nano>(static_cast<double>(at.count()) / options_.speed));
}

/// False: the queue is full, and the message is to be sent again.
bool Replay::send(const RecordedMessage& message) {
  const auto sent = line_->publish({options_.base + "/" + message.topic, message.payload, is_retained(message.topic),
                                    std::uint8_t{0}, transport::MqttQueue::kInOrder});
  if (!sent && sent.error().code == ErrorCode::kBusy) return false;
  if (!sent) log_.warning(fmt::format("{}: {}", message.topic, sent.error().text));
  return true;
}

}  // namespace rubicon::zigbee_simulator
