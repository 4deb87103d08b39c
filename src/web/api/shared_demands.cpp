#include "web/api/shared_demands.h"

#include <utility>

namespace rubicon::web::api {

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
