#pragma once

#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/scheduler.h"
#include "model/message.h"
#include "model/type_catalogue.h"
#include "network/line_reports.h"
#include "network/network.h"
#include "networks/log/file_chain.h"
#include "networks/log/log_options.h"
#include "networks/log/replay_clock.h"

namespace rubicon::networks::log {

/// The last reading of each point in a part of a recording that is searched and not played, so that devices show the
/// state of the moment at which it goes on. Keeps no events: what happened before does not happen again. Holds as many
/// readings as the recording has points.
class LastReadings {
 public:
  explicit LastReadings(const TypeCatalogue& types) : types_(types) {}

  void joined(const std::string& device, const model::Join& join);
  void left(const std::string& device) { devices_.erase(device); }
  /// `when` is the user time of readings that have none; zero = they stay without.
  void keep(const std::string& device, const model::Updates& updates, WallTime when);
  /// What was kept, by device; nothing is kept any more.
  std::vector<std::pair<std::string, model::Body>> take();
  void clear();

 private:
  struct Device {
    std::set<model::PointId> events;
    std::map<model::PointId, model::Reading> last;
  };
  bool is_event(const Device& device, const model::PointId& point) const;

  const TypeCatalogue& types_;
  std::map<std::string, Device> devices_;
};

/// A network of type `log`: delivers the messages of a recording when they are due, and does what users ask of the
/// replay (log_network_control.cpp).
class LogNetwork final : public network::Network {
 public:
  LogNetwork(const network::NetworkConfig& config, LogOptions options, network::NetworkHost& host);

  Result<void> open() override;
  Result<void> send(const Message& message) override;
  std::optional<std::vector<network::ListedDevice>> listed() const override;
  std::vector<network::Missing> missing() const override;
  std::vector<network::Control> controls() const override { return replay_controls(); }
  Result<void> control(std::string_view name, std::string_view text) override;

 private:
  Result<void> choose_format(const std::string& first_file);
  void leave_or_stay(const std::string& reason);
  void leave_some(const std::string& reason);
  std::unique_ptr<Recording> make_recording();
  void play();
  bool fetch();
  void deliver_step(std::size_t& weight);
  void line_up();
  void deliver(const std::string& device, model::Body body, WallTime when);
  /// The readings have the user times they were recorded with.
  bool has_user_times() const { return options_.recorded_times && recording_->has_user_times(); }
  bool plays_later();
  void finish();
  void play_again();
  Result<void> rewind();
  // What users set.
  Result<void> set_playing(bool playing);
  Result<void> go_to(std::string_view text);
  Result<RecordTime> time_of(const ReplayTarget& target) const;
  RecordTime here() const;
  void end_search();
  bool deliver_kept();
  void tick();
  void add_replay_texts(std::map<std::string, std::string>& texts) const;
  void fail_line(Error why);
  void end_line(const std::string& reason);
  void complain(std::uint64_t offset, std::string_view what);
  void report(model::LineState line, std::string reason = {});
  std::optional<model::State> state() const;

  LogOptions options_;
  network::NetworkHost& host_;
  const TypeCatalogue& types_;
  ReplayClock clock_;
  ReplayCounters counters_;
  std::unique_ptr<Recording> recording_;  ///< made by the first open(), which chooses the format
  std::unique_ptr<FileChain> chain_;
  std::optional<Step> step_;      ///< read, not yet due
  std::size_t next_message_ = 0;  ///< of step_; those before it are delivered
  bool up_ = false;
  bool ended_ = false;
  // Times of the recording: since 1970 where it has absolute times, else since its beginning.
  std::optional<RecordTime> begin_, end_;  ///< as far as they are known
  RecordTime time_{};                      ///< of the last step that was read
  std::optional<RecordTime> target_;       ///< the steps before it are searched, not played
  LastReadings last_readings_;             ///< before target_
  bool kept_ = false;                      ///< step_ holds them
  std::optional<Step> behind_kept_;        ///< the first step at or behind the target
  std::deque<std::string> leaving_;        ///< devices that leave at the end
  RecordTime position_{};
  std::uint64_t delivered_ = 0;  ///< messages, in this round
  std::uint64_t rounds_ = 0;
  bool step_back_logged_ = false;
  std::optional<model::LineState> line_;  ///< as reported; nullopt: not opened, or lost
  std::string reason_;
  base::LimitedLog log_;
  network::StateReporter reporter_;
  Timer timer_, tick_;
  base::OncePerTurn next_turn_;
};

}  // namespace rubicon::networks::log
