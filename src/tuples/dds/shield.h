#pragma once

#include <memory>

#include "tuples/dds/dds_trust.h"

namespace rubicon::tuples::dds {

/// While it lives, nobody but a member itself ends its participant in this process. Cyclone DDS 0.10 takes the end of
/// a participant from any packet that says so: in the name of its secure discovery writer, without a signature
/// (q_receive.c, handle_Data: "we accept data from unknown sources"; ddsi_security_omg.c,
/// is_proxy_participant_deletion_allowed), and in a message of liveliness; and it ties participants to any other one
/// that calls itself their service (DDSI2). Therefore functions of this room stand before two of Cyclone's.
/// A member that leaves is noticed by the end of its presence, and its participant by its lease.
class Shield {
 public:
  explicit Shield(std::shared_ptr<const DdsTrust> trust);
  ~Shield();
  Shield(const Shield&) = delete;
  Shield& operator=(const Shield&) = delete;

  /// False: a program loaded libddsc before this library, so that Cyclone calls its own functions.
  static bool is_first();

 private:
  std::shared_ptr<const DdsTrust> trust_;
};

}  // namespace rubicon::tuples::dds
