#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "base/log.h"
#include "base/scheduler.h"
#include "transport/interfaces.h"
#include "tuples/dds/channel.h"
#include "tuples/dds/dds_ecology.h"
#include "tuples/dds/entity.h"

namespace rubicon::tuples::dds {

/// A domain that all links left. A thread deletes it: Cyclone DDS waits there for receivers that do not acknowledge,
/// and for its own threads. The loop meanwhile takes what still arrives, because a full reader holds them up.
class FormerDomain {
 public:
  struct Remains {
    std::vector<std::shared_ptr<const void>> used{};  ///< by the entities: goes last
    Entity domain{};
    std::vector<dds_entity_t> frame_readers{};
    std::vector<Entity> entities{};  ///< go with the domain
    std::vector<std::unique_ptr<Channel>> channels{};
  };

  /// `deleted` is called in a turn of the loop. The scheduler must outlive it.
  FormerDomain(Remains remains, Scheduler& scheduler, DdsEcology::Post post, std::function<void()> deleted);
  /// Waits until it is deleted.
  ~FormerDomain();
  FormerDomain(const FormerDomain&) = delete;
  FormerDomain& operator=(const FormerDomain&) = delete;

  bool is_deleted() const { return done_->load(); }

 private:
  void read();
  void read_soon();

  Remains remains_;
  Scheduler& scheduler_;
  std::shared_ptr<std::atomic<bool>> done_ = std::make_shared<std::atomic<bool>>(false);
  std::shared_ptr<std::function<void()>> deleted_;  ///< gone: no listener must be called any more
  std::thread thread_;
  Timer timer_;
};

/// Moves the links of a process from one domain to another, where tuples and subscriptions stay. Follows the
/// interfaces: Cyclone DDS takes their addresses once, when a domain is made.
class Moves {
 public:
  /// Former domains that are not deleted yet; with so many, the next move waits.
  static constexpr std::size_t kMaxFormer = 4;

  struct Callbacks {
    /// Takes the domain from all links; without a domain nothing remains.
    std::function<FormerDomain::Remains()> leave;
    /// After an error some links may have come back: they leave again.
    std::function<Result<void>()> come_back;
  };

  Moves(std::vector<std::string> names, Scheduler& scheduler, DdsEcology::Post post, Log log, Callbacks calls);

  /// Does nothing but a warning if the system does not tell what changes.
  void follow(const transport::WatchInterfaces& watch);
  /// Moves in a later turn, whatever the addresses are, and stays outside for at least so long.
  void move_anyway(Duration outside);
  /// The names of the interfaces that can be used now; they count as used from now on.
  std::vector<std::string> take(const std::vector<transport::Interface>& present);
  /// Between two domains: the links come back by themselves.
  bool under_way() const { return arrival_.is_set(); }
  const InterfaceNews& news() const { return news_; }

 private:
  void look();
  void report(const std::vector<transport::Interface>& present);
  bool may_move();
  void move();
  bool delete_slowly(FormerDomain::Remains remains, std::function<void()> deleted);
  void arrive();
  void drop_deleted();

  std::vector<std::string> names_;
  Scheduler& scheduler_;
  DdsEcology::Post post_;
  Log log_;
  base::LimitedLog limited_log_;
  Callbacks callbacks_;
  std::vector<transport::Interface> used_;
  InterfaceNews news_;
  std::vector<std::unique_ptr<FormerDomain>> former_;
  Duration outside_{};
  base::Deadline look_, arrival_, departure_;
  std::unique_ptr<transport::InterfaceWatch> watch_;
};

}  // namespace rubicon::tuples::dds
