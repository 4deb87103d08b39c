#pragma once

#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "apps/simulators/zigbee/radio_device.h"
#include "base/log.h"
#include "base/scheduler.h"
#include "rubicon/result.hpp"
#include "transport/mqtt.h"

namespace rubicon::zigbee_simulator {

struct WorldOptions {
  std::string base = "zigbee2mqtt";
  std::string version = "2.14.1";
  std::string last_seen = "ISO_8601";  ///< advanced.last_seen: `disable`, `ISO_8601`, `ISO_8601_local`, `epoch`
  std::string output = "json";         ///< advanced.output, as `bridge/info` says; states are always JSON
  bool availability = true;
  bool optimistic = true;  ///< false: device_options.optimistic
  bool nulls = false;      ///< properties that were not reported yet are null instead of absent
  bool permit_join = false;
  Duration every{};  ///< each device reports what it measures so often; 0 = never by itself
  std::uint64_t seed = 1;
};

/// A group of the bridge.
struct DeviceGroup {
  int id = 0;
  std::string name;
  std::vector<std::string> members;  ///< addresses
  nlohmann::json state = nlohmann::json::object();
};

/// A Zigbee2MQTT without radio: devices, groups and the bridge's topics, with the messages, orders and delays that a
/// real one was recorded with (zigbee.md, sections 1 to 8; where the recording differs, as the recording). It publishes
/// through `publish`, and takes what clients publish by received(). Devices are named by friendly name or address.
class World {
 public:
  using Json = nlohmann::json;
  using Publish = std::function<void(transport::MqttPublication)>;

  struct Counters {
    std::uint64_t published = 0, sets = 0, gets = 0, requests = 0;
    std::uint64_t rejected = 0;  ///< sets and gets of which the bridge sends nothing to a device
  };

  /// Scheduler and log must outlive it.
  World(WorldOptions options, Scheduler& scheduler, Log log);
  ~World();
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  /// Where messages go while there is a connection; empty = nowhere.
  Publish publish;
  /// A friendly name is new, or no longer used: its topics are to be listened to.
  std::function<void(const std::string& name, bool used)> named;

  // -- the bridge
  /// The bridge begins: state, lists, and the cached state of every device (zigbee.md, section 2).
  void start();
  /// Connected to the broker again: only its state (section 2.4).
  void reconnected();
  /// Says that it is offline, and does nothing until start().
  void stop();
  /// stop(), and start() after this time.
  void restart(Duration pause);
  bool runs() const { return runs_; }
  /// A message of a client. Topics that are not the bridge's are ignored.
  void received(std::string_view topic, std::string_view payload);

  /// As by a request; zero ends it.
  void permit_join(Duration span) { permit(span); }

  // -- devices
  /// A device that was paired long ago, last heard an hour ago. kInvalid: the name is in use or not permitted.
  Result<RadioDevice*> add(DeviceModel model, std::string name = {});
  /// A device begins to pair. It waits until joining is permitted. Its name is its address.
  std::string join(DeviceModel model, bool fails = false);
  /// It was reset and pairs again: announces itself under its address.
  void announce(RadioDevice& device);
  void leave(const std::string& address);
  /// As by a request. kInvalid as add().
  Result<void> rename(RadioDevice& device, const std::string& to);
  /// nullptr if there is none.
  RadioDevice* find(std::string_view name_or_address);
  std::vector<RadioDevice*> devices();
  DeviceGroup& add_group(int id, std::string name, std::vector<std::string> members);

  /// The value changes on the device itself, which reports it.
  void change(RadioDevice& device, const std::string& property, Json value);
  /// An uncached property such as `action`: one message.
  void act(RadioDevice& device, const std::string& property, const Json& value);
  /// The device measures and reports; what waits for it to wake is sent.
  void report(RadioDevice& device);
  /// The bridge hears it, and learns nothing.
  void hear(RadioDevice& device);
  void set_faults(RadioDevice& device, Faults faults);
  /// Reports every `period`; 0 = never by itself.
  void report_every(RadioDevice& device, Duration period);

  // -- oddities of a bridge
  /// A list without these devices, and the right one 200 ms later.
  void shrink_list(const std::set<std::string>& addresses);
  /// A message of the bridge with any payload.
  void say(const std::string& topic, std::string payload, bool retain = false);
  void publish_devices();

  const WorldOptions& options() const { return options_; }
  const Counters& counters() const { return counters_; }
  bool joining() const { return joining_until_ > scheduler_.now(); }

 private:
  friend class Interviews;
  friend class Requests;
  struct Parts;

  // messages of the bridge
  void publish_info();
  void publish_groups();
  void publish_event(std::string_view type, const RadioDevice& device, Json more = Json::object());
  void publish_state(const RadioDevice& device, const Json& more = Json::object());
  void publish_availability(const RadioDevice& device);
  void publish_group(DeviceGroup& group);
  void publish_group_availability(const DeviceGroup& group);
  void publish_health();
  void publish_list(const std::set<std::string>& without);
  void start_devices();

  // what clients ask
  void set(std::string_view name, std::string_view property, std::string_view payload);
  void get(std::string_view name, std::string_view property, std::string_view payload);
  void set_device(RadioDevice& device, const Json& wanted);
  void answer_set(RadioDevice& device, const Json& accepted);
  void do_set(RadioDevice& device, const Json& accepted);
  void set_group(DeviceGroup& group, const Json& wanted);
  void answer_get(RadioDevice& device, const std::vector<std::string>& properties);
  void follow_members(const RadioDevice& member);
  DeviceGroup* find_group(std::string_view name_or_id);

  // devices
  void publish_report(RadioDevice& device, const std::vector<std::string>& properties);
  void clear_later(RadioDevice& device, const std::string& property);
  void mark(RadioDevice& device, bool online);
  void begin_period(RadioDevice& device);
  void next_period(const std::string& address);
  void start_interview(RadioDevice& device);
  void travel(RadioDevice& device, int goal);
  void permit(Duration span);
  void forget(const std::string& address);
  void forget_topics(const std::string& name);
  Result<void> check_name(std::string_view name) const;
  std::string next_address();
  RadioDevice& keep(DeviceModel model, std::string address, std::string name);
  void later(Duration delay, std::function<void()> call);
  void later(const RadioDevice& device, Duration delay, std::function<void(RadioDevice&)> call);

  WorldOptions options_;
  Scheduler& scheduler_;
  Log log_;
  Random random_;
  std::unique_ptr<Parts> parts_;
  std::vector<std::unique_ptr<RadioDevice>> devices_;
  std::map<std::string, RadioDevice*, std::less<>> by_name_, by_address_;
  std::map<int, DeviceGroup> groups_;
  std::map<std::string, Timer> periods_, silences_, clearings_, travels_;  ///< by address
  std::set<std::string, std::less<>> own_topics_;  ///< what it publishes on: what arrives there is no command
  std::map<std::uint64_t, Timer> timers_;
  std::uint64_t last_timer_ = 0;
  std::uint32_t last_address_ = 0;
  bool runs_ = false, restart_required_ = false;
  SteadyTime began_{}, joining_until_{};
  WallTime joining_end_{};
  Timer joining_, health_, restarting_;
  Counters counters_;
};

}  // namespace rubicon::zigbee_simulator
