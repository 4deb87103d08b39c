#include "bridges/mqtt/commands.h"

#include <fmt/format.h>

#include <algorithm>

#include "model/json_members.h"
#include "rubicon/key.hpp"
#include "transport/mqtt_topics.h"

namespace rubicon::bridges::mqtt {

namespace {

constexpr std::string_view kSet = "/set";
constexpr Duration kPatience = std::chrono::seconds(15);

tuples::RemoteSet remote_set(const PointEntry& point, std::string_view value) {
  tuples::RemoteSet set;
  set.owner = point.device->island;
  set.key = point.key + ".command";
  set.value = value;
  set.media_type = "text/plain";
  return set;
}

/// A response topic must not be a command.
bool can_answer_at(const std::string& base, std::string_view topic) {
  return !topic.empty() && topic.find_first_of("+#") == topic.npos && !topic.starts_with('$') &&
         !topic.starts_with(base + "/");
}

}  // namespace

Result<PointEntry*> Commands::check(const transport::MqttMessage& message, std::string_view topic) const {
  auto* point = house_.find_by_topic(topic);
  if (point == nullptr) return fail(ErrorCode::kNotFound, fmt::format("{}: no such point", topic));
  if (message.payload.size() > kMaxText)
    return fail(ErrorCode::kOutOfRange, fmt::format("{} bytes, expected at most {}", message.payload.size(), kMaxText));
  if (under_way_.size() >= kMaxUnderWay)
    return fail(ErrorCode::kBusy, fmt::format("{} commands are under way already", kMaxUnderWay));
  const auto set = remote_set(*point, message.payload);
  if (auto allowed = may(set, message.sender); !allowed) return fail(allowed.error());
  return point;
}

/// The configuration of the bridge first, then the rights of the island; what they refuse is in the audit.
Result<void> Commands::may(const tuples::RemoteSet& set, std::string_view sender) const {
  const tuples::Member member{"bridge:" + host_.name};
  Result<void> answer;
  if (!takes_command(options_, set.key))
    answer = fail(ErrorCode::kRefused,
                  fmt::format("{} may not set {}: its `commands` do not name it", member.name, set.key));
  if (!host_.judge) return answer;
  if (answer) answer = host_.judge->may_set(member, set);
  if (!answer)
    host_.judge->answered(member, sender, set, {{}, 0, Verdict::kRefused, answer.error().code, answer.error().text});
  return answer;
}

void Commands::take(const transport::MqttMessage& message) {
  if (!message.topic.ends_with(kSet) || message.retained) return;
  const auto topic = message.topic.substr(0, message.topic.size() - kSet.size());
  Way way{std::string(topic), std::string(message.response_topic), std::string(message.correlation)};
  if (!can_answer_at(options_.base, way.response)) way.response.clear();
  ++taken_;
  const auto point = check(message, topic);
  if (point) return send(**point, message, std::move(way));
  log_.info(way.topic, fmt::format("a command was refused: {}", point.error().text));
  answer(way, {"refused", point.error().text});
}

void Commands::send(const PointEntry& point, const transport::MqttMessage& message, Way way) {
  const auto lives = message.expiry > Duration(0) ? std::min(message.expiry, kMaxToLive) : kTimeToLive;
  const auto asker = "bridge:" + host_.name;
  tuples::ReplyCall noted;
  if (host_.judge) {
    noted = [judge = host_.judge, asker, sender = std::string(message.sender),
             set = remote_set(point, message.payload)](const Reply& reply) {
      judge->answered({asker}, sender, set, reply);
    };
  }
  const auto at = under_way_.insert(under_way_.end(), Running{});
  const auto ended = [this, at, way = std::move(way)](const client::Outcome& outcome) {
    answer(way, outcome);
    under_way_.erase(at);
  };
  SetOptions options;
  options.asker = asker;
  at->tracker = std::make_unique<client::RemoteSetTracker>(host_.scheduler, host_.space, point.device->island,
                                                           point.key + ".command", message.payload, ended, lives,
                                                           kPatience, nullptr, nullptr, options, std::move(noted));
  if (host_.judge) at->spoken_for = host_.judge->speak_for({asker}, host_.space.self(), at->tracker->request());
}

void Commands::answer(const Way& way, const client::Outcome& outcome) {
  const nlohmann::ordered_json json{{"state", outcome.state}, {"reason", outcome.reason}, {"request", outcome.request}};
  transport::MqttPublication message;
  message.topic = way.response.empty() ? way.topic + "/outcome" : way.response;
  message.payload = model::dump(json);
  message.qos = 1;
  message.correlation = way.correlation;
  if (transport::is_mqtt_topic(message.topic)) calls_.publish(std::move(message));
  if (outcome.good()) return;
  ++refused_;
  calls_.correct(way.topic);
}

}  // namespace rubicon::bridges::mqtt
