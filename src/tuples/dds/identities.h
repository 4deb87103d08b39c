#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "tuples/dds/dds_trust.h"
#include "tuples/dds/writers.h"

namespace rubicon::tuples::dds {

/// Who stands behind the DDS participants of a domain with trust: this process itself, or whom the guard authenticated.
/// Thread-safe.
class Identities {
 public:
  explicit Identities(std::shared_ptr<DdsTrust> trust) : trust_(std::move(trust)) {}
  Identities(const Identities&) = delete;
  Identities& operator=(const Identities&) = delete;

  /// A participant of this process, which never authenticates itself to the others here.
  void add_own(const GuidPrefix& participant);
  void clear_own();
  bool is_own(const GuidPrefix& participant) const;
  /// nullptr: it is not authenticated, or no longer a member. Do not keep that: it may become one.
  std::shared_ptr<const Member> who(const GuidPrefix& participant) const;
  /// DdsTrust::revoked()
  std::string revoked() const { return trust_->revoked(); }

 private:
  std::shared_ptr<DdsTrust> trust_;
  mutable std::mutex mutex_;
  std::map<GuidPrefix, std::shared_ptr<const Member>> own_;
};

/// A sample that claims an id which is not that of its writer.
struct FalseClaim {
  GuidPrefix participant{};
  std::string member;  ///< empty: none that is known
  OwnerId id{};
};

/// Checks the ids that the samples of one topic claim, on the threads of DDS.
class Claims {
 public:
  /// More are not noted until take().
  static constexpr std::size_t kMaxNoted = 16;

  /// `wake` runs on a thread of DDS when there is something to take. No identities: all may claim all.
  Claims(std::shared_ptr<const Identities> identities, std::function<void()> wake)
      : identities_(std::move(identities)), wake_(std::move(wake)) {}
  Claims(const Claims&) = delete;
  Claims& operator=(const Claims&) = delete;

  bool are_checked() const { return identities_ != nullptr; }
  /// Whether the certificate behind the participant has the id.
  bool may_use(const GuidPrefix& participant, OwnerId id);
  std::vector<FalseClaim> take();
  /// False claims since the start.
  std::uint64_t refused() const;

 private:
  std::shared_ptr<const Identities> identities_;
  std::function<void()> wake_;
  mutable std::mutex mutex_;
  std::vector<FalseClaim> noted_;
  std::uint64_t refused_ = 0;
};

/// The prefix of the GUID.
GuidPrefix prefix_of(const Participant& participant);
/// The GUID of the participant itself.
Participant participant_of(const GuidPrefix& prefix);
/// `desk (certificate 0A3F)`
std::string text_of(const Member& member);

}  // namespace rubicon::tuples::dds
