#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/deadline.h"
#include "base/limited_log.h"
#include "transport/interface_watch.h"
#include "tuples/dds/former_domain.h"
#include "tuples/dds/interface_news.h"

namespace rubicon::tuples::dds {

/// Follows the interfaces of a domain. Cyclone DDS takes their addresses once, when a domain is made: when they
/// changed, the links leave it and enter a new one with those that are there. Tuples and subscriptions stay.
class Moves {
 public:
  /// Former domains that are not deleted yet; with so many, the next move waits.
  static constexpr std::size_t kMaxFormer = 4;

  struct Calls {
    /// Takes the domain from all links; without a domain nothing remains.
    std::function<FormerDomain::Remains()> leave;
    std::function<Result<void>()> come_back;
  };

  Moves(std::vector<std::string> names, Scheduler& scheduler, DdsEcology::Post post, Log log, Calls calls);

  /// Does nothing but a warning if the system does not tell what changes.
  void follow(const transport::WatchInterfaces& watch);
  /// The names of the interfaces that can be used now; they count as used from now on.
  std::vector<std::string> take(const std::vector<transport::Interface>& present);
  /// Between two domains: the links come back by themselves.
  bool under_way() const { return arrival_.is_set(); }
  const InterfaceNews& news() const { return news_; }

 private:
  void look();
  void report(const std::vector<transport::Interface>& present);
  void move();
  void arrive();
  void drop_deleted();

  std::vector<std::string> names_;
  Scheduler& scheduler_;
  DdsEcology::Post post_;
  Log log_;
  base::LimitedLog limited_log_;
  Calls calls_;
  std::vector<transport::Interface> used_;
  InterfaceNews news_;
  std::vector<std::unique_ptr<FormerDomain>> former_;
  base::Deadline look_, arrival_;
  std::unique_ptr<transport::InterfaceWatch> watch_;
};

}  // namespace rubicon::tuples::dds
