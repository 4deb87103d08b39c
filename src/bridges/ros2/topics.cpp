#include "bridges/ros2/topics.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "bridges/ros2/names.h"
#include "model/findings.h"
#include "model/json_members.h"

namespace rubicon::bridges::ros2 {

namespace {

constexpr Duration kLookAgain = std::chrono::milliseconds(100);
/// Topics that are opened in one turn.
constexpr std::size_t kOpenedATurn = 250;
/// Of what waits for the end of one turn.
constexpr std::size_t kMaxSamples = 100'000;

std::string owner_of(const PointEntry& point) {
  return fmt::format("{}:{}", number(point.device->island), point.key);
}

}  // namespace

Topics::Topics(const BridgeHost& host, const Options& options, House& house)
    : host_(host),
      options_(options),
      house_(house),
      log_({host.log, "bridge " + host.name}, host.scheduler),
      desk_(host, options),
      soon_(host.scheduler, [this] { work(); }) {}

void Topics::attach(Node* node) {
  for (auto& [key, topic] : topics_) close(*topic);
  node_ = node;
  failure_.clear();
  for (auto& [key, topic] : topics_) unopened_.insert(topic.get());
  soon_.request();
}

void Topics::described(DeviceEntry& device) {
  devices_.insert(&device);
  soon_.request();
}

/// Devices that are complete get their topics, which are opened once all of them have their names; then what waits is
/// published.
void Topics::work() {
  for (auto at = devices_.begin(); at != devices_.end();) at = make_topics(**at) ? devices_.erase(at) : std::next(at);
  if (!devices_.empty() && !later_.pending()) later_ = host_.scheduler.after(kLookAgain, [this] { soon_.request(); });
  for (std::size_t i = 0; node_ != nullptr && i < kOpenedATurn && !unopened_.empty(); ++i)
    open(*unopened_.extract(unopened_.begin()).value());
  if (node_ != nullptr && !unopened_.empty()) soon_.request();
  for (const auto& sample : std::exchange(samples_, {})) publish(*sample.topic, sample.value, sample.time);
  for (auto* topic : std::exchange(marked_, {})) {
    topic->marked = false;
    publish_newest(*topic);
  }
}

/// False: not yet.
bool Topics::make_topics(DeviceEntry& device) {
  const auto* island = house_.find_island(device.island);
  const bool is_late = host_.scheduler.now() - device.since >= House::kComplete;
  const bool has_name = !options_.name_space.empty() || (island != nullptr && !island->name.empty());
  if (!house_.is_complete(device) || !(has_name || is_late)) return false;
  for (auto* point : device.points) {
    forget_other_form(*point);
    if (!point->about || by_point_.contains(point)) continue;
    if (options_.patterns.empty() && point->kind == model::Kind::kProperty) continue;
    const bool is_position = point->kind == model::Kind::kSensor && point->type() == "latitude";
    PointEntry* longitude = nullptr;
    if (is_position) {
      const auto key = fmt::format("{}.sensor.longitude-{}", device.key, point->instance());
      const auto found = std::find_if(device.points.begin(), device.points.end(),
                                      [&key](const auto* other) { return other->key == key; });
      if (found != device.points.end() && !by_point_.contains(*found)) longitude = *found;
    }
    make_topic(*point, longitude);
  }
  return true;
}

/// Described anew, a point may have values of another form.
void Topics::forget_other_form(PointEntry& point) {
  const auto found = by_point_.find(&point);
  if (found == by_point_.end() || found->second->longitude != nullptr || !point.about) return;
  if (found->second->form != form_of_point(point.kind, *point.about)) gone(point);
}

std::string Topics::space_of(const PointEntry& point) const {
  if (!options_.name_space.empty()) return options_.name_space;
  const auto* island = house_.find_island(point.device->island);
  return island != nullptr && !island->name.empty() ? island->name
                                                    : fmt::format("island_{}", number(point.device->island));
}

void Topics::make_topic(PointEntry& point, PointEntry* longitude) {
  const auto most = options_.patterns.empty() ? kMaxUsual : kMaxTopics;
  if (topics_.size() >= most) {
    left_out_.insert(&point);
    log_.warning("most", fmt::format("more than {} topics: `patterns` say which points are shown", most));
    return;
  }
  left_out_.erase(&point);
  auto topic = std::make_unique<Topic>();
  topic->point = &point;
  topic->longitude = longitude;
  topic->form = longitude != nullptr ? Form::kNavSatFix : form_of_point(point.kind, *point.about);
  topic->state = is_state(point.kind, *point.about);
  const auto key =
      longitude == nullptr ? point.key : fmt::format("{}.sensor.position-{}", point.device->key, point.instance());
  topic->wanted = ros_name(space_of(point), key);
  auto& made = *topic;
  by_point_[&point] = &made;
  if (longitude != nullptr) by_point_[longitude] = &made;
  topics_.emplace(&made, std::move(topic));
  auto& group = wanted_[made.wanted];
  group.insert(&made);
  if (group.size() != 2) return name(made);
  for (auto* one : group) name(*one);
}

/// Whom a command reaches must not depend on who came first: of several that want one name none has it.
void Topics::name(Topic& topic) {
  const auto owner = owner_of(*topic.point);
  const auto others = wanted_.at(topic.wanted).size() - 1;
  const auto name = others == 0 ? topic.wanted : distinct_name(topic.wanted, owner);
  if (name == topic.name) return;
  close(topic);
  by_name_.erase(std::exchange(topic.name, {}));
  if (!by_name_.try_emplace(name, &topic).second) return;
  topic.name = name;
  unopened_.insert(&topic);
  soon_.request();
  if (others > 0)
    log_.warning(name, fmt::format("{} is shown as {}: other points want the name {}, too", owner, name, topic.wanted));
}

void Topics::open(Topic& topic) {
  if (topic.name.empty()) return;
  const auto keep = [&](Result<Endpoint> opened, Endpoint& into) {
    if (!opened) {
      failure_ = opened.error().text;
      log_.warning("endpoint", failure_);
      return;
    }
    into = std::move(*opened);
    by_endpoint_[into.get()] = &topic;
  };
  keep(node_->writer(topic.name, topic.form, topic.state ? Keep::kState : Keep::kReadings), topic.values);
  if (may_command(*topic.point) && topic.longitude == nullptr) {
    keep(node_->reader(topic.name + "/set", topic.form, Keep::kReadings), topic.sets);
    keep(node_->writer(topic.name + "/outcome", Form::kString, Keep::kReadings), topic.outcomes);
  }
  if (topic.state) mark(topic);
}

void Topics::close(Topic& topic) {
  unopened_.erase(&topic);
  for (auto* endpoint : {&topic.values, &topic.sets, &topic.outcomes}) {
    by_endpoint_.erase(endpoint->get());
    endpoint->reset();
  }
  topic.readers = 0;
  topic.demand.reset();
  topic.longitude_demand.reset();
  topic.shown = topic.has_waiting = false;
}

void Topics::changed(PointEntry& point) {
  const auto found = by_point_.find(&point);
  if (found == by_point_.end()) return;
  auto& topic = *found->second;
  const bool is_new = std::exchange(point.fresh, false);
  const bool is_reading = !topic.state && topic.longitude == nullptr;
  if (is_reading && is_new && topic.readers > 0) {
    if (samples_.size() < kMaxSamples)
      samples_.push_back({&topic, point.value, point.time});
    else
      ++dropped_;
    return soon_.request();
  }
  if (is_new && !is_reading) topic.missed = true;
  if (topic.state || topic.missed) mark(topic);
}

void Topics::mark(Topic& topic) {
  if (std::exchange(topic.marked, true)) return;
  marked_.push_back(&topic);
  soon_.request();
}

/// A value that is not good is not published as one of now; if it becomes good again without a new reading, it is.
void Topics::publish(Topic& topic, std::string_view value, WallTime time) {
  const auto& point = *topic.point;
  if (!topic.values || (topic.readers == 0 && !topic.state) || !point.about) return;
  const bool good = point.good() || point.is_event();
  topic.missed = !good || value.empty();
  if (topic.missed) return;
  const Reading reading{value, topic.longitude != nullptr ? topic.longitude->value : std::string_view(),
                        point.device->id, time};
  dds_return_t answer = DDS_RETCODE_OK;
  const auto fits = with_message(topic.form, *point.about, reading,
                                 [&](const void* message) { answer = dds_write(topic.values.get(), message); });
  if (!fits) {
    ++unfit_;
    log_.warning("unfit", fmt::format("{}: {}", point.key, fits.error().text));
  } else if (answer != DDS_RETCODE_OK) {
    ++dropped_;
  } else {
    ++published_;
    topic.shown = topic.state;
  }
}

/// Of a state, or of a position; a state that is not of now is taken away.
void Topics::publish_newest(Topic& topic) {
  const auto& point = *topic.point;
  const bool good = point.good() && (topic.longitude == nullptr || topic.longitude->good());
  if (good) return publish(topic, point.value, point.time);
  topic.missed = true;
  if (!std::exchange(topic.shown, false)) return;
  std::ignore = with_message(topic.form, *point.about, {"0", {}, {}, {}},
                             [&](const void* message) { dds_dispose(topic.values.get(), message); });
}

void Topics::news(dds_entity_t endpoint) {
  const auto found = by_endpoint_.find(endpoint);
  if (found == by_endpoint_.end()) return;
  auto& topic = *found->second;
  if (endpoint == topic.values.get()) return follow_readers(topic);
  if (endpoint == topic.sets.get()) return take_commands(topic);
}

/// A reader of ROS is demand.
void Topics::follow_readers(Topic& topic) {
  topic.readers = matched_readers(topic.values.get());
  if (topic.readers == 0) {
    topic.demand.reset();
    topic.longitude_demand.reset();
    topic.missed = false;
  } else if (!topic.demand) {
    topic.demand = want(*topic.point);
    if (topic.longitude != nullptr) topic.longitude_demand = want(*topic.longitude);
  }
}

Handle Topics::want(const PointEntry& point) const {
  const auto key = point.key + ".value";
  if (host_.judge && !host_.judge->access({"bridge:" + host_.name}, key).demand) return {};
  return host_.space.subscribe({point.device->island, key}, {}, [](const Event&) {});
}

bool Topics::may_command(const PointEntry& point) const {
  return point.kind != model::Kind::kSensor && point.can_write() && takes_command(options_, point.key + ".command");
}

void Topics::take_commands(Topic& topic) {
  std::string newest;
  std::size_t taken = 0;
  const auto form = topic.form;
  tuples::dds::take<std::byte>(topic.sets.get(), SIZE_MAX, [&](const auto& message, const auto& info) {
    if (!info.valid_data) return;
    newest = command_text(form, *topic.point->about, &message);
    ++taken;
  });
  if (taken == 0) return;
  commands_ += taken;
  superseded_ += taken - 1 + (topic.has_waiting ? 1 : 0);
  topic.waiting = std::move(newest);
  topic.has_waiting = true;
  go_on(topic);
}

/// None faster than kCommandPause; the island lets a newer command supersede an older one.
void Topics::go_on(Topic& topic) {
  if (!topic.has_waiting || topic.pause.pending()) return;
  topic.has_waiting = false;
  topic.pause = host_.scheduler.after(kCommandPause, [this, &topic] { go_on(topic); });
  command(topic, std::move(topic.waiting));
}

void Topics::command(Topic& topic, std::string text) {
  if (const auto allowed = desk_.check(*topic.point, text, {}); !allowed) {
    log_.info(topic.name, fmt::format("a command was refused: {}", allowed.error().text));
    return answer(topic, {"refused", allowed.error().text});
  }
  desk_.send(*topic.point, text, {}, CommandDesk::kTimeToLive,
             lifetime_.guard([this, of = owner_of(*topic.point), name = topic.name](const client::Outcome& outcome) {
               const auto found = by_name_.find(name);  // it may be gone, or another one of that name
               if (found != by_name_.end() && owner_of(*found->second->point) == of) answer(*found->second, outcome);
             }));
}

void Topics::answer(Topic& topic, const client::Outcome& outcome) {
  if (!outcome.good()) ++refused_;
  if (!topic.outcomes) return;
  const nlohmann::ordered_json json{{"state", outcome.state}, {"reason", outcome.reason}, {"request", outcome.request}};
  const auto text = model::dump(json);
  std::ignore = with_message(Form::kString, {}, {text, {}, {}, {}},
                             [&](const void* message) { dds_write(topic.outcomes.get(), message); });
}

void Topics::gone(PointEntry& point) {
  left_out_.erase(&point);
  const auto found = by_point_.find(&point);
  if (found == by_point_.end()) return;
  auto& topic = *found->second;
  close(topic);
  if (topic.marked) std::erase(marked_, &topic);
  std::erase_if(samples_, [&topic](const auto& sample) { return sample.topic == &topic; });
  by_name_.erase(topic.name);
  const auto group = wanted_.find(topic.wanted);
  group->second.erase(&topic);
  if (group->second.size() == 1) name(**group->second.begin());
  if (group->second.empty()) wanted_.erase(group);
  by_point_.erase(topic.point);
  by_point_.erase(topic.longitude);
  topics_.erase(&topic);
  if (!left_out_.empty()) described(*(*left_out_.begin())->device);
}

void Topics::gone(DeviceEntry& device) {
  for (auto* point : device.points) gone(*point);
  devices_.erase(&device);
}

void Topics::complain(BridgeStatus& status) const {
  if (!failure_.empty()) status.add({}, failure_);
  if (!left_out_.empty())
    status.add({}, fmt::format("{} points are not shown: `patterns` say which ones are", left_out_.size()));
  const auto clashes = [](const auto& group) { return group.second.size() > 1; };
  const auto first = std::find_if(wanted_.begin(), wanted_.end(), clashes);
  if (first == wanted_.end()) return;
  std::set<std::string> owners;
  for (const auto* topic : first->second) owners.insert(owner_of(*topic->point));
  const auto others = std::count_if(std::next(first), wanted_.end(), clashes);
  status.add(
      model::findings::kRosNamesClash,
      fmt::format("{} is wanted by {} and {}{}: each has a number behind its name{}", first->first, *owners.begin(),
                  *std::next(owners.begin()), owners.size() == 2 ? "" : fmt::format(" and {} more", owners.size() - 2),
                  others == 0 ? "" : fmt::format("; {} more names alike", others)));
}

void Topics::count(std::map<std::string, std::uint64_t>& counters) const {
  const auto readers =
      std::count_if(topics_.begin(), topics_.end(), [](const auto& one) { return one.second->readers > 0; });
  counters["topics"] = topics_.size();
  counters["topics-read"] = static_cast<std::uint64_t>(readers);
  counters["published"] = published_;
  counters["dropped"] = dropped_;
  counters["unfit"] = unfit_;
  counters["commands"] = commands_;
  counters["commands-refused"] = refused_;
  counters["commands-superseded"] = superseded_;
}

}  // namespace rubicon::bridges::ros2
