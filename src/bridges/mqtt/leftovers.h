#pragma once

#include <map>
#include <set>
#include <string>

#include "bridges/mqtt/discovery.h"
#include "bridges/mqtt/house.h"
#include "transport/mqtt.h"

namespace rubicon::bridges::mqtt {

/// What a run before left at the broker: retained messages of devices that are gone, and announcements of another form.
/// Filled by the retained messages of filters() after each connection.
class Leftovers {
 public:
  /// Until then the devices of an island have come, also those that are heard late.
  static constexpr Duration kSettled = std::chrono::seconds(60);
  static constexpr std::size_t kMaxTopics = 200'000;

  Leftovers(const Options& options, House& house, const Announcer& announcer)
      : options_(options), house_(house), announcer_(announcer) {}

  std::vector<std::string> filters() const;
  void take(const transport::MqttMessage& message);
  /// Whether a value of a run before stands there.
  bool has(std::string_view topic) const { return topics_.contains(topic); }
  /// Whether it is our announcement of a run before, in the form that is not in force: its entities have the same ids.
  bool is_other_form(const transport::MqttMessage& message) const;
  /// A message on a topic of discovery that is ours and says something else: two bridges announce one device.
  bool is_disputed() const { return disputed_; }
  void begin() {
    topics_.clear();
    disputed_ = false;
  }
  /// The topics to empty: what `kept` (announcements) and the house do not have, of islands that are there.
  std::set<std::string> gone(const std::set<std::string>& kept);

 private:
  bool is_gone(const std::string& topic) const;

  const Options& options_;
  House& house_;
  const Announcer& announcer_;
  std::map<std::string, bool, std::less<>> topics_;  ///< whether it is an announcement
  bool disputed_ = false;
};

}  // namespace rubicon::bridges::mqtt
