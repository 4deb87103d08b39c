#include "native/subscription.h"

#include <utility>

namespace rubicon::python {

py::object text_or_none(std::string_view bytes) {
  auto* text = PyUnicode_DecodeUTF8(bytes.data(), static_cast<Py_ssize_t>(bytes.size()), "strict");
  if (text == nullptr) {
    PyErr_Clear();
    return py::none();
  }
  return py::reinterpret_steal<py::object>(text);
}

double seconds_of(WallTime time) {
  return base::to_seconds(time);
}

Subscription::Subscription(TupleSpace& space, const Pattern& pattern, const Flow& flow, bool full, py::function call)
    : full_(full), call_(std::move(call)) {
  handle_ = space.subscribe(
      pattern, flow, [this](const Event& event) { take(event); }, [this](OwnerId owner) { add_snapshot(owner); });
  add_snapshot(space.self());  // of own tuples nothing has to arrive first
}

void Subscription::peer_changed(OwnerId peer, bool present) {
  (present ? present_ : absent_).append(model::number(peer));
  due_ = true;
}

void Subscription::add_snapshot(OwnerId owner) {
  snapshots_.push_back(owner);
  due_ = true;
}

void Subscription::take(const Event& event) {
  name_.assign(std::to_string(model::number(event.tuple.owner)));
  name_.append(1, ':').append(event.tuple.key);
  due_ = true;
  if (event.kind == EventKind::kSet) return set(event.tuple);
  const auto found = numbers_.find(name_);
  if (found == numbers_.end()) return;
  gone_.append(py::make_tuple(found->second, std::string(tuples::to_string(event.kind))));
  numbers_.erase(found);
}

void Subscription::set(const TupleView& tuple) {
  const auto [place, is_new] = numbers_.try_emplace(name_, last_number_);
  if (is_new) keys_[py::int_(last_number_++)] = name_;
  const auto time = tuple.user_time == WallTime{} ? tuple.write_time : tuple.user_time;
  py::list entry(full_ ? 5 : 4);
  entry[0] = py::int_(place->second);
  entry[1] = text_or_none(tuple.value);
  entry[2] = py::int_(tuple.sequence);
  entry[3] = py::float_(seconds_of(time));
  if (full_) entry[4] = py::dict(py::arg("m") = std::string(tuple.media_type));
  sets_.append(std::move(entry));
}

void Subscription::flush() {
  py::dict frame;
  const auto add = [&frame]<class Member>(const char* name, Member& member) {
    if (!member.empty()) frame[name] = std::exchange(member, Member());
  };
  add("absent", absent_);
  add("present", present_);
  add("k", keys_);
  add("set", sets_);
  add("gone", gone_);
  const auto snapshots = std::exchange(snapshots_, {});
  due_ = false;
  const auto call = call_;  // it may end this subscription
  if (!frame.empty()) call(std::move(frame));
  for (const auto owner : snapshots) call(py::dict(py::arg("snapshot") = model::number(owner)));
}

}  // namespace rubicon::python
