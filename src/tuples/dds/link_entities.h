#pragma once

#include <functional>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "tuples/dds/dds_ecology.h"
#include "tuples/dds/dds_threads.h"
#include "tuples/dds/entity.h"
#include "tuples/dds/moves.h"
#include "tuples/dds/reader_stores.h"

namespace rubicon::tuples::dds {

class DdsLink;

/// What the links of a process share; it outlives them.
struct LinkShared {
  DdsOptions options;
  Scheduler& scheduler;
  DdsEcology::Post post;
  base::LogSink& log;
  std::function<Duration()> since_boot = base::since_boot;
  std::shared_ptr<ComponentStarts> starts = std::make_shared<ComponentStarts>();
  std::set<DdsLink*> links = {};       ///< all of them
  Patience patience = {};              ///< of links that leave
  std::function<void()> overrun = {};  ///< a reader keeps too much: only another one is without it

  /// Whether the participant is of one of these links.
  bool has(const Participant& who) const;
};

/// The component of a link and its present start.
struct OwnStart {
  OwnerId id{};
  std::uint64_t incarnation = 0;
  LinkListener* listener = nullptr;  ///< null: not attached. Each call of it may detach the link.
};

/// The DDS entities of one link: its participant with the three topics, a reader of each, and the writers of its
/// presence and its interests. Frames have a writer for each destination (Channel).
class LinkEntities {
 public:
  /// All must outlive it. An empty participant: the link is outside of the domain.
  LinkEntities(OwnerId self, Duration lease, const Signal& signal, Entity participant)
      : self_(self), lease_(lease), signal_(signal), participant_(std::move(participant)) {}

  /// Makes what is missing; outside of the domain nothing. Readers are made first, so that a component that sees this
  /// one can reach it. kIo names the entity that cannot be made.
  Result<void> make();
  /// Enters the domain with this participant. The same error.
  Result<void> make_in(Entity participant);
  /// Deletes all but the participant and the topics.
  void delete_readers_and_writers();
  void delete_all();
  /// Leaves the domain, and takes out what is to be deleted with it.
  void leave_behind(FormerDomain::Remains& remains);

  bool in_domain() const { return static_cast<bool>(participant_); }
  dds_entity_t participant() const { return participant_.get(); }
  dds_entity_t frame_topic() const { return frame_topic_.get(); }
  dds_entity_t presence_reader() const { return presence_reader_.get(); }
  dds_entity_t interest_reader() const { return interest_reader_.get(); }
  dds_entity_t frame_reader() const { return frame_reader_.get(); }
  dds_entity_t presence_writer() const { return presence_writer_.get(); }
  dds_entity_t interest_writer() const { return interest_writer_.get(); }
  /// Of what the readers of presence and of interests keep.
  InstanceQuota& presence_quota() { return stores_->presence_quota; }
  InstanceQuota& interest_quota() { return stores_->interest_quota; }

 private:
  Result<void> make_topics();
  Result<void> make_readers();
  Result<void> make_writers();
  Result<Entity> group_in(const std::string& what, const std::vector<std::string>& partitions, bool of_readers) const;

  OwnerId self_;
  Duration lease_;
  const Signal& signal_;
  std::shared_ptr<ReaderStores> stores_ = std::make_shared<ReaderStores>();
  Entity participant_, presence_topic_, interest_topic_, frame_topic_;
  Entity all_subscriber_, presence_reader_, interest_reader_, frame_subscriber_, frame_reader_;
  Entity presence_publisher_, presence_writer_, interest_publisher_, interest_writer_;
};

}  // namespace rubicon::tuples::dds
