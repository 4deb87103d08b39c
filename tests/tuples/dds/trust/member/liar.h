#pragma once

#include <map>

#include "base/bytes.h"
#include "tuples/dds/entity.h"
#include "tuples/dds/trust/member/honest.h"

namespace rubicon::tuples::dds {

/// A member with a certificate of its own that speaks DDS by itself, and says to be others.
class Liar {
 public:
  Liar(GuardTrust& trust, OwnerId own, const std::string& own_partition);

  bool good() const { return interests_ && presences_; }
  /// `lists COUNT`, `spy PARTITION`, `frames`, `presence ID INCARNATION`, `dispose ...`, `interest ID INCARNATION`,
  /// `frame PARTITION SOURCE INCARNATION TARGET_INCARNATION KEY VALUE`,
  /// `reply PARTITION SOURCE INCARNATION TARGET TARGET_INCARNATION REQUEST`, `readers`
  void obey(const Words& words);

 private:
  void frame(const Words& words);
  void reply(const Words& words);
  /// Where words[1] to words[4] say, as in `frame`.
  void send(const Words& words, std::uint64_t target_incarnation, Bytes bytes);
  void readers();
  void lists(int count, std::size_t bytes);
  void presences(int count, std::size_t bytes);
  void spy(const std::string& partition);

  std::uint32_t own_;
  Entity domain_, participant_, presence_topic_, interest_topic_, frame_topic_, publisher_, presences_, interests_;
  Entity subscriber_, spy_;
  std::map<std::string, std::pair<Entity, Entity>> channels_;  ///< by partition: publisher, writer
};

}  // namespace rubicon::tuples::dds
