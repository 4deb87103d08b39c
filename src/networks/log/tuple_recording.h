#pragma once

#include <deque>
#include <memory>
#include <set>
#include <string>
#include <unordered_map>
#include <vector>

#include "networks/log/recorded_device.h"
#include "networks/log/recorded_networks.h"
#include "networks/log/recording.h"
#include "recording/recording_reader.h"

namespace rubicon::networks::log {

/// Recordings of our own (docs/recording-format.md): the tuples of one recorded network, as what its devices said.
/// Descriptions become joins, values readings with their user times; commands say nothing, and statuses only whether a
/// value was heard or stored from before. Bounded in memory, and in what one next() does, whatever the files hold.
class TupleRecording final : public Recording {
 public:
  /// `network`: which one; empty = the only one there is.
  TupleRecording(const TypeCatalogue& types, std::string network, ReplayCounters& counters, Complaint complain);

  /// What a hostile recording may make us remember; what is beyond is told once and not played.
  static constexpr std::size_t kMaxDevices = 20'000;
  static constexpr std::size_t kMaxPoints = 2048;  ///< of one device
  static constexpr std::size_t kMaxKeys = 500'000;
  static constexpr std::size_t kMaxText = 64 << 20;  ///< bytes of all keys, and of all descriptions
  static constexpr std::size_t kMaxDescription = 256 << 10;

  void begin(std::string_view file_name, std::vector<std::string> labels) override;
  void restart() override;
  void feed(ByteView bytes) override { reader_.feed(bytes); }
  void end() override;
  std::optional<Step> next() override;
  bool has_more() const override { return has_more_; }
  bool ready() const override { return !failure_ && !naming_ && (chosen_by_user_ ? head_read_ : looked_ahead_); }
  std::optional<Error> failure() const override { return failure_; }
  bool absolute_times() const override { return true; }
  bool has_user_times() const override { return true; }
  RecordTime period() const override { return RecordTime{0}; }
  std::vector<std::string> devices() const override;

 private:
  static constexpr std::size_t kReaderShare = 4 << 20;
  enum class Role : std::uint8_t { kUnknown, kOther, kDevice, kPoint, kValue, kStatus };
  /// What a key means for us.
  struct Place {
    Role role = Role::kUnknown;
    RecordedDevice* device = nullptr;
    RecordedPoint* point = nullptr;
  };
  struct TextHash {
    using is_transparent = void;
    std::size_t operator()(std::string_view text) const { return std::hash<std::string_view>{}(text); }
  };
  template <class T>
  using ByText = std::unordered_map<std::string, T, TextHash, std::equal_to<>>;

  bool go_on();
  bool go_on_naming();
  bool spent() const;
  bool do_chores();
  std::optional<recording::Record> next_record();
  void on_head(const recording::FileHead& head);
  void on_block();
  void on_damage(const recording::Damage& damage);
  void take(const recording::Record& record);
  void on_mark(const recording::Record& record);
  void on_device(RecordedDevice& device, const recording::Record& record);
  void on_point(RecordedDevice& device, RecordedPoint& point, const recording::Record& record);
  void on_value(RecordedDevice& device, RecordedPoint& point, const recording::Record& record);
  void on_status(RecordedDevice& device, RecordedPoint& point, const recording::Record& record);
  bool must_wait(const RecordedDevice& device, const RecordedPoint& point) const;
  void hold(RecordedDevice& device, RecordedPoint& point, Value value, const recording::Record& record);
  void tell_held(RecordedDevice& device, RecordedPoint& point);
  void begin_session(RecordedPoint& point) const;

  Place place_of(const recording::Record& record);
  Place remember(std::string_view key);
  Place resolve(std::string_view key);
  void choose_network(std::string_view found) {
    if (chosen_by_user_) return;
    if (network_.empty()) network_ = found;
    naming_ = networks_.size() > 1;
  }
  RecordedDevice* device_called(std::string_view id);
  RecordedPoint* point_called(RecordedDevice& device, std::string_view kind, std::string_view id);

  void look_later(RecordedDevice& device);
  void settle(RecordedDevice& device);
  void snapshot_complete();
  bool take_room(std::size_t before, std::size_t after);
  void too_many(std::string_view what, std::size_t bound);
  void join(RecordedDevice& device);
  void leave(RecordedDevice& device, std::string reason);
  void tell(RecordedDevice& device, RecordedPoint& point, Value value, WallTime user_time);
  void bad(const std::string& text);

  ForeignTypes types_;
  std::string network_;
  ReplayCounters& counters_;
  Complaint complain_;
  recording::RecordingReader reader_{kReaderShare};
  std::string prefix_ = "proxy.";
  OwnerId island_ = model::kNoOwner;
  bool chosen_by_user_;
  RecordedNetworks networks_;  ///< found so far
  bool head_read_ = false;
  bool looked_ahead_ = false;
  bool naming_ = false;  ///< several networks and none chosen: read on for their names only
  std::optional<Error> failure_;
  ByText<std::unique_ptr<RecordedDevice>> devices_;
  ByText<Place> keys_;
  std::vector<Place> places_;  ///< by the key numbers of the present block
  std::deque<RecordedDevice*> unsettled_;
  bool settling_ = false;                ///< the turn is over: unsettled devices come first
  bool completing_ = false;              ///< then those that a complete snapshot does not name
  std::deque<RecordedDevice*> missing_;  ///< and leave
  std::size_t work_ = 0;                 ///< since others had their turn, in small records
  bool has_more_ = false;
  std::size_t key_text_ = 0, described_ = 0;  ///< bytes remembered
  std::size_t held_ = 0;                      ///< bytes of values that wait
  std::set<std::string, std::less<>> bounds_told_;
  std::uint64_t session_ = 1;
  Step step_;
  std::optional<recording::Record> kept_;  ///< the first record of the next step
  WallTime turn_{};
  std::uint64_t snapshot_ = 0;
  bool in_snapshot_ = false;
  bool snapshot_is_sound_ = false;
  WallTime snapshot_since_{};
};

}  // namespace rubicon::networks::log
