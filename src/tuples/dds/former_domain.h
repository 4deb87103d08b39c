#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include "base/scheduler.h"
#include "tuples/dds/channel.h"
#include "tuples/dds/dds_ecology.h"
#include "tuples/dds/entity.h"

namespace rubicon::tuples::dds {

/// A domain that all links left. A thread deletes it: Cyclone DDS waits there for receivers that do not acknowledge,
/// and for its own threads. The loop meanwhile takes what still arrives, because a full reader holds them up.
class FormerDomain {
 public:
  struct Remains {
    Entity domain;
    std::vector<dds_entity_t> frame_readers{};
    std::vector<Entity> entities{};  ///< go with the domain
    std::vector<std::unique_ptr<Channel>> channels{};
    std::vector<std::shared_ptr<const void>> used{};  ///< by the entities
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
  std::shared_ptr<std::function<void()>> deleted_;  ///< gone: nobody is to be told any more
  std::thread thread_;
  Timer timer_;
};

}  // namespace rubicon::tuples::dds
