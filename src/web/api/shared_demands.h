#pragma once

#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <tuple>

#include "rubicon/tuple_space.hpp"

namespace rubicon::web::api {

/// The demand of callers whose rights decide about each tuple: one subscription for each tuple and pace, which all
/// connections share. Outlives all shares.
class SharedDemands {
 public:
  static constexpr std::size_t kMax = 8000;  ///< an owner takes 10,000 subscriptions of a component

  explicit SharedDemands(TupleSpace& space) : space_(space) {}
  SharedDemands(const SharedDemands&) = delete;
  SharedDemands& operator=(const SharedDemands&) = delete;

  /// The demand lasts as long as one of its shares.
  class Demand;
  using Share = std::shared_ptr<Demand>;
  /// nullptr: there are kMax.
  Share of(OwnerId owner, std::string_view key, const Flow& flow);
  std::size_t size() const { return demands_.size(); }

 private:
  using Name = std::tuple<OwnerId, std::string, Duration, Duration, double>;

  TupleSpace& space_;
  std::map<Name, std::weak_ptr<Demand>> demands_;
};

}  // namespace rubicon::web::api
