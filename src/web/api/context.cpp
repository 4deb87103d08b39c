#include "web/api/context.h"

#include <utility>

#include "model/point_keys.h"
#include "model/point_tuples.h"

namespace rubicon::web::api {

Sets EventTypes::sets_of(OwnerId owner, std::string_view key) {
  if (!key.ends_with(".value") || !model::point_of(key)) return Sets::kStates;
  const auto id = model::last_part(model::parent_key(key));
  const auto type = id.substr(0, id.find('-'));
  if (const auto* known = catalogue_.find(type))
    return known->report == model::Report::kEvent ? Sets::kEvents : Sets::kStates;
  return is_open_event(owner, key, type) ? Sets::kEvents : Sets::kUnknown;
}

bool EventTypes::is_open_event(OwnerId owner, std::string_view key, std::string_view type) {
  const auto name = std::pair(owner, std::string(type));
  const auto known = open_types_.find(name);
  if (known != open_types_.end()) return known->second.is_event;
  if (open_types_.size() >= kMaxOpenTypes) return false;
  auto& open = open_types_[name];
  open.description = space_.subscribe({owner, model::point_of(key)->description()}, {.passive = true},
                                      [&open](const tuples::Event& event) {
                                        const auto about = model::point_description_from_json(event.tuple.value);
                                        if (about) open.is_event = about->report == "event";
                                      });
  return false;
}

void RecentReads::keep(const Pattern& pattern) {
  const auto name = to_string(pattern);
  auto& kept = kept_[name];
  if (!kept.subscription) kept.subscription = space_.subscribe(pattern, {.passive = true}, [](const tuples::Event&) {});
  kept.end = scheduler_.after(kTime, [this, name] { kept_.erase(name); });
}

class SharedDemands::Demand {
 public:
  Demand(SharedDemands& all, Name name, tuples::Handle handle)
      : all_(all), name_(std::move(name)), handle_(std::move(handle)) {}
  ~Demand() { all_.demands_.erase(name_); }
  Demand(const Demand&) = delete;
  Demand& operator=(const Demand&) = delete;

 private:
  SharedDemands& all_;
  Name name_;
  tuples::Handle handle_;
};

SharedDemands::Share SharedDemands::of(OwnerId owner, std::string_view key, const Flow& flow) {
  Name name{owner, std::string(key), flow.minimum, flow.maximum, flow.dead_band};
  if (const auto found = demands_.find(name); found != demands_.end()) return found->second.lock();
  if (demands_.size() >= kMax) return nullptr;
  auto handle = space_.subscribe({owner, std::string(key)}, flow, [](const tuples::Event&) {});
  auto share = std::make_shared<Demand>(*this, name, std::move(handle));
  demands_.emplace(std::move(name), share);
  return share;
}

}  // namespace rubicon::web::api
