#pragma once

#include <gmock/gmock.h>

#include "model/message.h"
#include "scenarios/roaming.h"
#include "support/rights.h"

namespace rubicon::scenarios {

using support::Right;
using support::rule;

inline constexpr std::uint32_t kRobotId = 70001;
inline constexpr const char* kLampCommand = "proxy.scripted-1.7.actuator.switch-1.command";
/// For start(): a network `scripted-2`.
inline constexpr const char* kSecondNetwork = "}\n  scripted-2: {type: scripted";

/// Islands that know who asks, each with rights and an audit of its own.
class RightsOfMessages : public Ecology {
 protected:
  void start(std::uint32_t id, std::vector<rights::Rule> rules, const std::string& more = "") {
    audits[id] = std::make_shared<support::CollectingAudit>();
    ecology.certify(OwnerId(id), support::island_member(id));
    judges[id] = support::judge_of(std::move(rules), audits[id]);
    ecology.judge(OwnerId(id), judges[id]);
    start_island(id, more);
    devices_of(id).say("7", lamp());
    scheduler.run_ready();
  }
  TupleSpace& member(std::uint32_t id, const std::string& name) {
    ecology.certify(OwnerId(id), support::tool_member(name, id));
    return component(id);
  }
  TupleSpace& robot() { return member(kRobotId, "robot"); }

  Message switch_on(std::uint32_t island) {
    Message message;
    message.destination = {OwnerId(island), "scripted-1", "7"};
    message.body = model::Actuate{1, actuator("switch"), true};
    return message;
  }
  Message note(std::uint32_t island, const std::string& network = "", const std::string& device = "") {
    Message message;
    message.destination = {OwnerId(island), network, device};
    message.body = model::Opaque{"note", {'h', 'i'}};
    return message;
  }
  /// A component without a gateway posts a message. What the island replied.
  tuples::Reply post(TupleSpace& from, std::uint32_t to, const Message& message) {
    tuples::Reply answer;
    const auto bytes = model::to_cbor(message);
    tuples::SetOptions options;
    options.media_type = model::kMessageMediaType;
    from.set_remote(
        OwnerId(to), "GATEWAY", base::as_text(bytes), 1s, [&](const tuples::Reply& reply) { answer = reply; }, options);
    scheduler.run_for(1s);
    return answer;
  }
  /// The texts of what the robot is answered go to `answers`.
  Handle hear_answers() {
    std::ignore = robot().declare("GATEWAY");
    return robot().add_policy({OwnerId(kRobotId), "GATEWAY"}, [this](const tuples::RemoteSet& set) {
      const auto message = model::from_cbor(base::as_bytes(set.value));
      answers.push_back(std::get<model::Acknowledge>(message->body).text + " from " + to_string(message->source));
      return tuples::SetDecision::consumed();
    });
  }
  std::vector<std::string>& audit(std::uint32_t id) { return audits[id]->lines; }
  std::size_t commands(std::uint32_t island) { return devices_of(island).commands.size(); }

  std::map<std::uint32_t, std::shared_ptr<support::CollectingAudit>> audits;
  std::map<std::uint32_t, std::shared_ptr<rights::RightsJudge>> judges;
  std::vector<std::string> answers;
};

}  // namespace rubicon::scenarios
